#include "daemon/control/printer_status.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/control/control_fixture.hpp"

namespace {

class PrinterStatusFixture : public testing::ControlFixture {
 public:
  PrinterStatusFixture() { checks.check_result = JobRefusal{"it takes 900 MB", true}; }
};

}  // namespace

TEST_CASE("An idle printer's status has all keys in their order") {
  PrinterStatusFixture fixture;
  std::string keys;
  const auto status = fixture.status.status();
  for (const auto& [key, value] : status.items())
    keys += key + " ";
  CHECK(keys ==
        "printer spool state job queued incomplete incomplete_more postponed postponed_more "
        "unaccepted unaccepted_more ignored "
        "ignored_more deletable deletable_more plate plate_job not_ready_reason held waiting_for "
        "reminders last dark manual ");
  CHECK(status["state"] == "idle");
  for (const char* nothing : {"job", "plate_job", "not_ready_reason", "held", "waiting_for", "last"})
    CHECK(status[nothing].is_null());
  CHECK(status["plate"] == "clear");
}

TEST_CASE("A reply does not grow with the number of jobs") {
  PrinterStatusFixture fixture;
  for (int i = 0; i < 1'002; ++i) {
    fixture.queue.arrived(std::to_string(i) + ".stl");
    fixture.queue.check_next();
  }
  CHECK(fixture.status.queue()["queue"].size() == 1'000);
  CHECK(fixture.status.queue()["queue"][0] == "0.stl");
  CHECK(fixture.status.queue()["more"] == 2);
  const auto status = fixture.status.status();
  CHECK(status["queued"] == 1'002);
  CHECK(status["postponed"].size() == 10);
  CHECK(status["postponed"]["0.stl"] == "it takes 900 MB");
  CHECK(status["postponed_more"] == 992);
}

TEST_CASE("A job is preparing, then its print's state, then finishing") {
  PrinterStatusFixture fixture;
  fixture.begin();
  CHECK(fixture.status.status()["state"] == "preparing");
  CHECK(fixture.status.status()["job"].size() == 2);  // name and analysis
  std::vector<std::string> states;
  REQUIRE(fixture.run_to_end([&] {
    if (fixture.job.job() == nullptr) return;
    const auto status = fixture.status.status();
    const auto state = status["state"].get<std::string>();
    if (state == "preparing") return;  // until the reader has finished
    if (states.empty() || states.back() != state) states.push_back(state);
    if (state == "exposing" && status["job"]["layers_done"] == 0) {
      CHECK(status["job"]["layer"] == 1);
      CHECK(status["plate_job"] == "part");
    }
  }));
  CHECK(states.front() == "warming up");
  CHECK(states.back() == "finishing");
}

TEST_CASE("The status has the job that ended last, without its analysis") {
  PrinterStatusFixture fixture;
  fixture.history.add({"one", "done", "", {{"layers", 3}}});
  fixture.history.add({"two", "failed", "no model"});
  CHECK(fixture.status.status()["last"].dump() == R"({"job":"two","outcome":"failed","reason":"no model"})");
}
