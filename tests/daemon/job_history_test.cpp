#include "daemon/job_history.hpp"

#include "tests/catch.hpp"

using namespace contourd;

TEST_CASE("The latest ended jobs are remembered, the oldest first") {
  JobHistory history;
  for (std::size_t i = 0; i <= JobHistory::kLongest; ++i)
    history.add({std::to_string(i), "done", ""});
  REQUIRE(history.jobs().size() == JobHistory::kLongest);
  CHECK(history.jobs().front().name == "1");
  CHECK(history.jobs().back().name == std::to_string(JobHistory::kLongest));
}
