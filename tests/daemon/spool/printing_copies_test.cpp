#include "daemon/spool/printing_copies.hpp"

#include <filesystem>
#include <string>

#include "tests/catch.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

class Desk : public testing::SpoolFixture {
 public:
  Desk() {
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

TEST_CASE("A copy is whole in printing/, and its original is removed where that is possible") {
  Desk desk;
  const JobCopy copy = desk.copies.copy("part.stl");
  REQUIRE(copy.job);
  CHECK(copy.job->original.empty());
  CHECK(desk.text_of("printing/part.stl") == "one");
  CHECK(desk.has("printing/part.json"));
  CHECK_FALSE(desk.has("incoming/part.stl"));
  CHECK_FALSE(desk.has("incoming/part.json"));
  CHECK_FALSE(desk.has("printing/.copies"));
}

TEST_CASE("A copy gets a name that no job has") {
  Desk desk;
  desk.put("done/part.stl");
  const JobCopy copy = desk.copies.copy("part.stl");
  REQUIRE(copy.job);
  CHECK(copy.job->name != "part");
}

TEST_CASE("No end of a print is known of a copy that begins") {
  Desk desk;
  desk.records.keep_end_of_print("{}");
  REQUIRE(desk.copies.copy("part.stl").job);
  CHECK(desk.records.end_of_print().empty());
}

TEST_CASE("What cannot be read can be refused, and says why") {
  Desk desk;
  fs::remove(desk.original().model);
  fs::create_symlink("elsewhere.stl", desk.folder.path() / "incoming" / "part.stl");
  const JobCopy copy = desk.copies.copy("part.stl");
  CHECK_FALSE(copy.job);
  CHECK_FALSE(copy.unreadable.empty());
  CHECK(copy.trouble.empty());
}

TEST_CASE("A plate whose ticket is wrong can be refused") {
  Desk desk;
  desk.put("incoming/plate/plate.json", "no ticket");
  CHECK(desk.copies.copy("plate").unreadable.starts_with("the job ticket is wrong: "));
}

TEST_CASE("What the disk does not take is tried again, and leaves nothing in printing/") {
  Desk desk;
  fs::create_directories(desk.folder.path() / "state" / "copied-originals" / "full");
  const JobCopy copy = desk.copies.copy("part.stl");
  CHECK_FALSE(copy.job);
  CHECK_FALSE(copy.trouble.empty());
  CHECK(fs::is_empty(desk.folders.path(SpoolFolder::Printing)));
  CHECK(desk.has("incoming/part.stl"));
}

TEST_CASE("Behind a stop nothing is copied, and what was begun is given up") {
  Desk desk;
  desk.copies.stop();
  const JobCopy copy = desk.copies.copy("part.stl");
  CHECK_FALSE(copy.job);
  CHECK_FALSE(copy.trouble.empty());
  CHECK(fs::is_empty(desk.folders.path(SpoolFolder::Printing)));
}

TEST_CASE("A copy that is taken back goes, and its original may be taken again") {
  Desk desk;
  JobFiles copy = desk.original();
  copy.model = desk.folder.path() / "printing" / "part.stl";
  copy.ticket = desk.folder.path() / "printing" / "part.json";
  copy.original = "part.stl";
  desk.put("printing/part.stl", "one");
  desk.put("printing/part.json", "{}");
  desk.originals.add(mark_of(desk.original()));
  REQUIRE(desk.originals.contains(desk.original()));
  desk.copies.take_back(copy);
  CHECK_FALSE(desk.originals.contains(desk.original()));
  CHECK(fs::is_empty(desk.folders.path(SpoolFolder::Printing)));
  CHECK(desk.has("incoming/part.stl"));
}

TEST_CASE("What a daemon was copying when it was killed goes, and jobs in printing/ stay") {
  Desk desk;
  desk.put("printing/.copies/half.stl");
  desk.put("printing/part.stl");
  desk.copies.remove_leftovers();
  CHECK_FALSE(desk.has("printing/.copies"));
  CHECK(desk.has("printing/part.stl"));
}
