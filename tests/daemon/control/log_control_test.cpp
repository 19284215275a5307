#include "daemon/control/log_control.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;

namespace {

class LogControlFixture {
 public:
  ControlMethod::Json entries(const ControlMethod::Json& parameters = ControlMethod::Json::object()) {
    return control.methods().at("log").call(parameters, {})["entries"];
  }

  EventLoop loop;
  testing::LogText log{loop};
  LogControl control{log.log};
};

}  // namespace

TEST_CASE_METHOD(LogControlFixture, "The latest entries of the log are reported, the oldest first") {
  CHECK(entries().empty());
  log.log.info("first", "one");
  log.log.warning("second", "two\x1b[2J");
  const auto both = entries();
  REQUIRE(both.size() == 2);
  CHECK(both[0]["message"] == "one");
  CHECK(both[0]["level"] == "info");
  CHECK(both[1]["event"] == "second");
  CHECK(both[1]["message"] == "two?[2J");
  CHECK(entries({{"last", 1}})[0]["event"] == "second");
}

TEST_CASE_METHOD(LogControlFixture, "The memory of the log is bounded, and so is a reply") {
  for (std::size_t i = 0; i < 2 * Log::kMostRecent; ++i)
    log.log.info("event", std::to_string(i) + std::string(100'000, 'x'));
  CHECK(log.log.recent().size() == Log::kMostRecent);
  std::size_t bytes = 0;
  for (const auto& each : entries({{"last", Log::kMostRecent}})) {
    const auto message = each["message"].get<std::string>();
    CHECK(message.size() < Log::kLongestRecent + 50);  // a note says how long the rest is
    bytes += message.size();
  }
  CHECK(bytes <= LogControl::kMostBytes);
  CHECK(entries().back()["message"].get<std::string>().starts_with("399x"));
}
