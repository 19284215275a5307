#include "daemon/spool/printing_copies.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"

namespace fs = std::filesystem;

namespace {

class PrintingCopiesFixture : public testing::SpoolFixture {
 public:
  PrintingCopiesFixture() {
    fs::create_directory(folder.path() / "state");
    put("incoming/part.stl", "one");
    put("incoming/part.json", "{}");
  }
  [[nodiscard]] JobFiles original() const { return folders.files_of(SpoolFolder::Incoming, "part.stl"); }

  StateRecords records{folder.path() / "state"};
  JobEndRecord ends{records};
  CopiedOriginals originals{folder.path() / "state" / "copied-originals"};
  PrintingCopies copies{folders, ends, originals};
};

}  // namespace

TEST_CASE_METHOD(PrintingCopiesFixture,
                 "A copy is complete in printing/, and its original is removed if possible") {
  const JobCopy copy = copies.copy("part.stl");
  REQUIRE(copy.job);
  CHECK(copy.job->original.empty());
  CHECK(text_of("printing/part.stl") == "one");
  CHECK(has("printing/part.json"));
  CHECK_FALSE(has("incoming/part.stl"));
  CHECK_FALSE(has("incoming/part.json"));
  CHECK_FALSE(has("printing/.copies"));
}

TEST_CASE_METHOD(PrintingCopiesFixture, "A copy gets a name that no job has") {
  put("done/part.stl");
  const JobCopy copy = copies.copy("part.stl");
  REQUIRE(copy.job);
  CHECK(copy.job->name != "part");
}

TEST_CASE_METHOD(PrintingCopiesFixture, "A copy has no end, even if an earlier job had its name") {
  ends.add({.key = 1, .job = "part", .outcome = "done"});
  REQUIRE(copies.copy("part.stl").job);
  CHECK_FALSE(JobEndRecord(records).end_of("part"));
}

TEST_CASE_METHOD(PrintingCopiesFixture, "A job that cannot be read can be refused with the reason") {
  fs::remove(original().model);
  fs::create_symlink("elsewhere.stl", folder.path() / "incoming" / "part.stl");
  const JobCopy copy = copies.copy("part.stl");
  CHECK_FALSE(copy.job);
  CHECK_FALSE(copy.unreadable.empty());
  CHECK(copy.trouble.empty());
}

TEST_CASE_METHOD(PrintingCopiesFixture, "A plate whose ticket is wrong can be refused") {
  put("incoming/plate/plate.json", "no ticket");
  CHECK(copies.copy("plate").unreadable.starts_with("the job ticket is wrong: "));
}

TEST_CASE_METHOD(PrintingCopiesFixture,
                 "A copy that the disk does not accept leaves nothing in printing/ and can be retried") {
  fs::create_directories(folder.path() / "state" / "copied-originals" / "full");
  const JobCopy copy = copies.copy("part.stl");
  CHECK_FALSE(copy.job);
  CHECK_FALSE(copy.trouble.empty());
  CHECK(fs::is_empty(folders.path(SpoolFolder::Printing)));
  CHECK(has("incoming/part.stl"));
}

TEST_CASE_METHOD(PrintingCopiesFixture, "After a stop, nothing is copied") {
  copies.stop();
  const JobCopy copy = copies.copy("part.stl");
  CHECK_FALSE(copy.job);
  CHECK_FALSE(copy.trouble.empty());
  CHECK(fs::is_empty(folders.path(SpoolFolder::Printing)));
}

TEST_CASE_METHOD(PrintingCopiesFixture,
                 "A copy that is taken back is removed, and its original can be taken again") {
  JobFiles copy = original();
  copy.model = folder.path() / "printing" / "part.stl";
  copy.ticket = folder.path() / "printing" / "part.json";
  copy.original = "part.stl";
  put("printing/part.stl", "one");
  put("printing/part.json", "{}");
  originals.add(mark_of(original()));
  REQUIRE(originals.contains(original()));
  copies.take_back(copy);
  CHECK_FALSE(originals.contains(original()));
  CHECK(fs::is_empty(folders.path(SpoolFolder::Printing)));
  CHECK(has("incoming/part.stl"));
}

TEST_CASE_METHOD(PrintingCopiesFixture,
                 "The unfinished copy of a killed daemon is removed, and jobs in printing/ stay") {
  put("printing/.copies/half.stl");
  put("printing/part.stl");
  copies.remove_leftovers();
  CHECK_FALSE(has("printing/.copies"));
  CHECK(has("printing/part.stl"));
}
