#include "daemon/spool/state_records.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

TEST_CASE("A record keeps its value for the next process until it is removed") {
  const testing::TemporaryFolder folder;
  const StateRecords records(folder.path());
  CHECK_FALSE(records.plate_occupant());
  CHECK_FALSE(records.hold());
  CHECK(records.job_ends().empty());
  records.set_plate_occupant("part");
  records.set_hold("part failed");
  records.keep_job_ends({"1", ""});
  const StateRecords next(folder.path());
  CHECK(next.plate_occupant() == "part");
  CHECK(next.hold() == "part failed");
  CHECK(next.job_ends() == std::vector<std::string>{"1", ""});
  next.set_plate_occupant(std::nullopt);
  next.set_hold(std::nullopt);
  next.keep_job_ends({});
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("A record with an unchanged value is not written again") {
  const testing::TemporaryFolder folder;
  const StateRecords records(folder.path());
  records.set_hold("part failed");
  const fs::path file = folder.path() / "queue-held";
  const auto long_ago = fs::last_write_time(file) - std::chrono::hours{1};
  fs::last_write_time(file, long_ago);
  records.set_hold("part failed");
  CHECK(fs::last_write_time(file) == long_ago);
  records.set_hold("another failed");
  CHECK(fs::last_write_time(file) != long_ago);
}

TEST_CASE("A record that the disk does not accept is an error, and a missing one can be removed") {
  const testing::TemporaryFolder folder;
  const StateRecords records(folder.path() / "gone");
  CHECK_THROWS_AS(records.set_hold("part failed"), std::system_error);
  CHECK_NOTHROW(records.set_hold(std::nullopt));
  CHECK_NOTHROW(records.keep_job_ends({}));
}

TEST_CASE("The queue's order is kept for the next process with any file names") {
  const testing::TemporaryFolder folder;
  const StateRecords records(folder.path());
  CHECK(records.queue_order().empty());
  const std::vector<std::string> files{"b.stl", "two\nlines.stl", "\xff .stl"};
  records.keep_queue_order(files);
  CHECK(StateRecords(folder.path()).queue_order() == files);
  records.keep_queue_order({});
  CHECK(fs::is_empty(folder.path()));
  CHECK_NOTHROW(records.keep_queue_order({}));
}

TEST_CASE("Accepted findings are kept for the next process") {
  const testing::TemporaryFolder folder;
  const StateRecords records(folder.path());
  CHECK(records.accepted().empty());
  records.keep_accepted({"a1 islands", "a1 cracks"});
  CHECK(StateRecords(folder.path()).accepted() == std::vector<std::string>{"a1 islands", "a1 cracks"});
  records.keep_accepted({});
  CHECK(fs::is_empty(folder.path()));
}
