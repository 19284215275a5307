#include "daemon/spool/job_moves.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"

namespace fs = std::filesystem;

namespace {

class JobMovesFixture : public testing::SpoolFixture {
 public:
  JobMovesFixture() {
    put("incoming/part.stl");
    put("incoming/part.json", "{}");
  }
  [[nodiscard]] JobFiles from() const { return folders.files_of(SpoolFolder::Incoming, "part.stl"); }
  [[nodiscard]] JobFiles to() const { return folders.named(SpoolFolder::Printing, "part", from()); }
};

}  // namespace

TEST_CASE("A job moves with its ticket") {
  const JobMovesFixture fixture;
  move_files(fixture.folders, fixture.from(), fixture.to());
  CHECK(fixture.has("printing/part.stl"));
  CHECK(fixture.has("printing/part.json"));
  CHECK(fs::is_empty(fixture.folders.path(SpoolFolder::Incoming)));
}

TEST_CASE("A ticket that belongs to two models is copied, and stays when one of them is removed") {
  const JobMovesFixture fixture;
  fixture.put("incoming/part.STL");
  const JobFiles from = fixture.from();
  move_files(fixture.folders, from, fixture.to());
  CHECK(fixture.has("printing/part.json"));
  CHECK(fixture.has("incoming/part.json"));
  fixture.put("incoming/part.stl");
  remove_files(fixture.folders, from);
  CHECK_FALSE(fixture.has("incoming/part.stl"));
  CHECK(fixture.has("incoming/part.json"));
}

TEST_CASE("A job whose ticket cannot be moved stays whole where it is") {
  const JobMovesFixture fixture;
  fixture.put("printing/part.json/full");
  CHECK_THROWS_AS(move_files(fixture.folders, fixture.from(), fixture.to()), std::system_error);
  CHECK(fixture.has("incoming/part.stl"));
  CHECK(fixture.has("incoming/part.json"));
  CHECK_FALSE(fixture.has("printing/part.stl"));
}

TEST_CASE("A job whose ticket disappears meanwhile is moved without it") {
  const JobMovesFixture fixture;
  const JobFiles from = fixture.from(), to = fixture.to();
  fs::remove(*from.ticket);
  move_files(fixture.folders, from, to);
  CHECK(fixture.has("printing/part.stl"));
}

TEST_CASE("A job that is removed takes its own ticket with it") {
  const JobMovesFixture fixture;
  remove_files(fixture.folders, fixture.from());
  CHECK(fs::is_empty(fixture.folders.path(SpoolFolder::Incoming)));
}

TEST_CASE("A move updates the change time, and a missing file has none") {
  const JobMovesFixture fixture;
  const auto before = change_time(fixture.from().model);
  CHECK(before > 0);
  const JobFiles to = fixture.to();
  // The kernel's clock for files ticks every few milliseconds.
  for (int i = 0; i < 1'000'000 && change_time(to.model) <= before; ++i) {
    if (fixture.has("incoming/part.stl"))
      fs::rename(fixture.from().model, to.model);
    else
      fs::rename(to.model, fixture.folders.path(SpoolFolder::Incoming) / "part.stl");
  }
  CHECK(change_time(to.model) > before);
  CHECK(change_time(fixture.folder.path() / "gone") == 0);
}
