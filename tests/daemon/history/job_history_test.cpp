#include "daemon/history/job_history.hpp"

#include "tests/catch.hpp"

TEST_CASE("The latest ended jobs are kept, the oldest first") {
  JobHistory history;
  for (std::size_t i = 0; i <= JobHistory::kLongest; ++i)
    history.add({std::to_string(i), "done", ""});
  REQUIRE(history.jobs().size() == JobHistory::kLongest);
  CHECK(history.jobs().front().name == "1");
  CHECK(history.jobs().back().name == std::to_string(JobHistory::kLongest));
}

TEST_CASE("The number of ended jobs with each outcome is counted") {
  JobHistory history;
  CHECK(history.counts() == JobHistory::Counts{{"done", 0}, {"cancelled", 0}, {"failed", 0}});
  for (int i = 0; i < 250; ++i)
    history.add({"part", i % 5 == 0 ? "failed" : "done", ""});
  CHECK(history.counts() == JobHistory::Counts{{"done", 200}, {"cancelled", 0}, {"failed", 50}});
}
