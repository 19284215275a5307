#include "daemon/spool/spool_lock.hpp"

#include <filesystem>
#include <stdexcept>
#include <string>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
namespace fs = std::filesystem;

TEST_CASE("A spool has one user, who may take it again, until that is gone") {
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

TEST_CASE("A folder that was put in the spool's place is taken too") {
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

TEST_CASE("Nobody but its user reads the lock, and a folder that is not there is told") {
  const testing::TemporaryFolder folder;
  SpoolLock lock;
  lock.take(folder.path());
  CHECK(fs::status(folder.path() / ".lock").permissions() ==
        (fs::perms::owner_read | fs::perms::owner_write));
  std::string told;
  try {
    lock.take(folder.path() / "gone");
  } catch (const std::runtime_error& error) {
    told = error.what();
  }
  CHECK(told.starts_with("cannot write in the spool "));
}
