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
  CopiedOriginals originals{folder.path() / "state" / "copied-originals"};
  PrintingCopies copies{folders, records, originals};
};

}  // namespace

TEST_CASE("A copy is complete in printing/, and its original is removed if possible") {
  PrintingCopiesFixture fixture;
  const JobCopy copy = fixture.copies.copy("part.stl");
  REQUIRE(copy.job);
  CHECK(copy.job->original.empty());
  CHECK(fixture.text_of("printing/part.stl") == "one");
  CHECK(fixture.has("printing/part.json"));
  CHECK_FALSE(fixture.has("incoming/part.stl"));
  CHECK_FALSE(fixture.has("incoming/part.json"));
  CHECK_FALSE(fixture.has("printing/.copies"));
}

TEST_CASE("A copy gets a name that no job has") {
  PrintingCopiesFixture fixture;
  fixture.put("done/part.stl");
  const JobCopy copy = fixture.copies.copy("part.stl");
  REQUIRE(copy.job);
  CHECK(copy.job->name != "part");
}

TEST_CASE("A copy removes the recorded end of the previous print") {
  PrintingCopiesFixture fixture;
  fixture.records.keep_end_of_print("{}");
  REQUIRE(fixture.copies.copy("part.stl").job);
  CHECK(fixture.records.end_of_print().empty());
}

TEST_CASE("A job that cannot be read can be refused with the reason") {
  PrintingCopiesFixture fixture;
  fs::remove(fixture.original().model);
  fs::create_symlink("elsewhere.stl", fixture.folder.path() / "incoming" / "part.stl");
  const JobCopy copy = fixture.copies.copy("part.stl");
  CHECK_FALSE(copy.job);
  CHECK_FALSE(copy.unreadable.empty());
  CHECK(copy.trouble.empty());
}

TEST_CASE("A plate whose ticket is wrong can be refused") {
  PrintingCopiesFixture fixture;
  fixture.put("incoming/plate/plate.json", "no ticket");
  CHECK(fixture.copies.copy("plate").unreadable.starts_with("the job ticket is wrong: "));
}

TEST_CASE("A copy that the disk does not accept leaves nothing in printing/ and can be retried") {
  PrintingCopiesFixture fixture;
  fs::create_directories(fixture.folder.path() / "state" / "copied-originals" / "full");
  const JobCopy copy = fixture.copies.copy("part.stl");
  CHECK_FALSE(copy.job);
  CHECK_FALSE(copy.trouble.empty());
  CHECK(fs::is_empty(fixture.folders.path(SpoolFolder::Printing)));
  CHECK(fixture.has("incoming/part.stl"));
}

TEST_CASE("After a stop, nothing is copied") {
  PrintingCopiesFixture fixture;
  fixture.copies.stop();
  const JobCopy copy = fixture.copies.copy("part.stl");
  CHECK_FALSE(copy.job);
  CHECK_FALSE(copy.trouble.empty());
  CHECK(fs::is_empty(fixture.folders.path(SpoolFolder::Printing)));
}

TEST_CASE("A copy that is taken back is removed, and its original can be taken again") {
  PrintingCopiesFixture fixture;
  JobFiles copy = fixture.original();
  copy.model = fixture.folder.path() / "printing" / "part.stl";
  copy.ticket = fixture.folder.path() / "printing" / "part.json";
  copy.original = "part.stl";
  fixture.put("printing/part.stl", "one");
  fixture.put("printing/part.json", "{}");
  fixture.originals.add(mark_of(fixture.original()));
  REQUIRE(fixture.originals.contains(fixture.original()));
  fixture.copies.take_back(copy);
  CHECK_FALSE(fixture.originals.contains(fixture.original()));
  CHECK(fs::is_empty(fixture.folders.path(SpoolFolder::Printing)));
  CHECK(fixture.has("incoming/part.stl"));
}

TEST_CASE("The unfinished copy of a killed daemon is removed, and jobs in printing/ stay") {
  PrintingCopiesFixture fixture;
  fixture.put("printing/.copies/half.stl");
  fixture.put("printing/part.stl");
  fixture.copies.remove_leftovers();
  CHECK_FALSE(fixture.has("printing/.copies"));
  CHECK(fixture.has("printing/part.stl"));
}
