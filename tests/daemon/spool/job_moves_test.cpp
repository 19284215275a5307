#include "daemon/spool/job_moves.hpp"

#include <filesystem>
#include <system_error>

#include "tests/catch.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

class Desk : public testing::SpoolFixture {
 public:
  Desk() {
    put("incoming/part.stl");
    put("incoming/part.json", "{}");
  }
  [[nodiscard]] JobFiles from() const { return folders.files_of(SpoolFolder::Incoming, "part.stl"); }
  [[nodiscard]] JobFiles to() const { return folders.named(SpoolFolder::Printing, "part", from()); }
};

}  // namespace

TEST_CASE("A job moves with its ticket") {
  const Desk desk;
  move_files(desk.folders, desk.from(), desk.to());
  CHECK(desk.has("printing/part.stl"));
  CHECK(desk.has("printing/part.json"));
  CHECK(fs::is_empty(desk.folders.path(SpoolFolder::Incoming)));
}

TEST_CASE("A ticket that is meant for another model too is copied, and stays when one of them is removed") {
  const Desk desk;
  desk.put("incoming/part.STL");
  const JobFiles from = desk.from();
  move_files(desk.folders, from, desk.to());
  CHECK(desk.has("printing/part.json"));
  CHECK(desk.has("incoming/part.json"));
  desk.put("incoming/part.stl");
  remove_files(desk.folders, from);
  CHECK_FALSE(desk.has("incoming/part.stl"));
  CHECK(desk.has("incoming/part.json"));
}

TEST_CASE("A job whose ticket cannot be moved stays whole where it is") {
  const Desk desk;
  desk.put("printing/part.json/full");
  CHECK_THROWS_AS(move_files(desk.folders, desk.from(), desk.to()), std::system_error);
  CHECK(desk.has("incoming/part.stl"));
  CHECK(desk.has("incoming/part.json"));
  CHECK_FALSE(desk.has("printing/part.stl"));
}

TEST_CASE("A ticket that is gone in that moment keeps no job from being moved") {
  const Desk desk;
  const JobFiles from = desk.from(), to = desk.to();
  fs::remove(*from.ticket);
  move_files(desk.folders, from, to);
  CHECK(desk.has("printing/part.stl"));
}

TEST_CASE("A job that is removed takes its own ticket with it") {
  const Desk desk;
  remove_files(desk.folders, desk.from());
  CHECK(fs::is_empty(desk.folders.path(SpoolFolder::Incoming)));
}

TEST_CASE("What is moved has changed, and what is not there never has") {
  const Desk desk;
  const auto before = change_time(desk.from().model);
  CHECK(before > 0);
  const JobFiles to = desk.to();
  // The kernel's clock for files ticks every few milliseconds.
  for (int i = 0; i < 1'000'000 && change_time(to.model) <= before; ++i) {
    if (desk.has("incoming/part.stl"))
      fs::rename(desk.from().model, to.model);
    else
      fs::rename(to.model, desk.folders.path(SpoolFolder::Incoming) / "part.stl");
  }
  CHECK(change_time(to.model) > before);
  CHECK(change_time(desk.folder.path() / "gone") == 0);
}
