#include "daemon/control/printer_status.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/control/control_fixture.hpp"

namespace {

class PrinterStatusFixture : public testing::ControlFixture {
 public:
  PrinterStatusFixture() { checks.check_result = JobRefusal{"it takes 900 MB", true}; }
};

}  // namespace

TEST_CASE_METHOD(PrinterStatusFixture, "An idle printer's status has all keys in their order") {
  std::string keys;
  const auto shown = status.status();
  for (const auto& [key, value] : shown.items())
    keys += key + " ";
  CHECK(keys ==
        "printer spool state job queued incomplete incomplete_more postponed postponed_more "
        "unaccepted unaccepted_more ignored "
        "ignored_more deletable deletable_more plate plate_job not_ready_reason held interrupted "
        "waiting_for reminders last dark manual camera ");
  CHECK(shown["state"] == "idle");
  for (const char* nothing :
       {"job", "plate_job", "not_ready_reason", "held", "interrupted", "waiting_for", "last"})
    CHECK(shown[nothing].is_null());
  CHECK(shown["plate"] == "clear");
}

TEST_CASE_METHOD(PrinterStatusFixture, "A reply does not grow with the number of jobs") {
  for (int i = 0; i < 1'002; ++i) {
    queue.arrived(std::to_string(i) + ".stl");
    queue.check_next();
  }
  CHECK(status.queue()["queue"].size() == 1'000);
  CHECK(status.queue()["queue"][0] == "0.stl");
  CHECK(status.queue()["more"] == 2);
  const auto shown = status.status();
  CHECK(shown["queued"] == 1'002);
  CHECK(shown["postponed"].size() == 10);
  CHECK(shown["postponed"]["0.stl"] == "it takes 900 MB");
  CHECK(shown["postponed_more"] == 992);
}

TEST_CASE_METHOD(PrinterStatusFixture, "A job is preparing, then its print's state, then finishing") {
  begin();
  CHECK(status.status()["state"] == "preparing");
  CHECK(status.status()["job"].size() == 3);  // name, analysis and supports
  std::vector<std::string> states;
  REQUIRE(run_to_end([&] {
    if (job.job() == nullptr) return;
    const auto shown = status.status();
    const auto state = shown["state"].get<std::string>();
    if (state == "preparing") return;  // until the reader has finished
    if (states.empty() || states.back() != state) states.push_back(state);
    if (state == "exposing" && shown["job"]["layers_done"] == 0) {
      CHECK(shown["job"]["layer"] == 1);
      CHECK(shown["plate_job"] == "part");
    }
  }));
  CHECK(states.front() == "warming up");
  CHECK(states.back() == "finishing");
}

TEST_CASE_METHOD(PrinterStatusFixture, "The status has the job that ended last, without its analysis") {
  history.add({"one", "done", "", {{"layers", 3}}});
  history.add({"two", "failed", "no model"});
  CHECK(status.status()["last"].dump() == R"({"job":"two","outcome":"failed","reason":"no model"})");
}
