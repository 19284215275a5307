#include "daemon/spool/spool.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

TEST_CASE("One process at a time can lock a spool, and can lock it again") {
  const testing::TemporaryFolder folder;
  SpoolLock other;
  {
    SpoolLock lock;
    lock.take(folder.path());
    CHECK_NOTHROW(lock.take(folder.path()));
    CHECK_THROWS_AS(other.take(folder.path()), std::runtime_error);
  }
  CHECK_NOTHROW(other.take(folder.path()));
}

TEST_CASE("A folder that was put in the spool's place is locked too") {
  const testing::TemporaryFolder folder;
  const fs::path spool = folder.path() / "spool";
  fs::create_directory(spool);
  SpoolLock lock, other;
  lock.take(spool);
  fs::rename(spool, folder.path() / "old");
  fs::create_directory(spool);
  lock.take(spool);
  CHECK_THROWS_AS(other.take(spool), std::runtime_error);
}

TEST_CASE("Other users cannot read the lock, and a missing folder is an error") {
  const testing::TemporaryFolder folder;
  SpoolLock lock;
  lock.take(folder.path());
  CHECK(fs::status(folder.path() / ".lock").permissions() ==
        (fs::perms::owner_read | fs::perms::owner_write));
  CHECK(testing::message_of<std::runtime_error>([&] {
          lock.take(folder.path() / "gone");
        }).starts_with("cannot write to the spool "));
}
