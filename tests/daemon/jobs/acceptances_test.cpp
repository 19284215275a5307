#include "daemon/jobs/acceptances.hpp"

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"

using namespace contourd;
using Lines = Acceptances::Lines;
namespace fs = std::filesystem;

namespace {

class Desk {
 public:
  std::vector<Lines> kept;
  std::function<void(const std::string&)> answer;  // the disk's
  std::vector<std::string> troubles;
  Acceptances acceptances{[this](const Lines& lines, auto done) {
                            kept.push_back(lines);
                            answer = std::move(done);
                          },
                          [this](const std::string& trouble) { troubles.push_back(trouble); }};
};

class Incoming : public testing::SpoolFixture {
 public:
  [[nodiscard]] std::string mark() const {
    return content_mark(folders.files_of(SpoolFolder::Incoming, "part.stl"));
  }
};

}  // namespace

TEST_CASE("What was accepted is these findings of these contents alone") {
  Desk desk;
  desk.acceptances.add("a1", {"islands", "cracks"});
  CHECK(desk.acceptances.has("a1", "islands"));
  CHECK(desk.acceptances.has("a1", "cracks"));
  CHECK_FALSE(desk.acceptances.has("a1", "empty_layers"));
  CHECK_FALSE(desk.acceptances.has("a2", "islands"));
  desk.acceptances.remove("a1");
  CHECK_FALSE(desk.acceptances.has("a1", "islands"));
}

TEST_CASE("What was accepted is there for the next process, one write at a time and the latest last") {
  Desk desk;
  desk.acceptances.load({"a0 islands"});
  CHECK(desk.acceptances.has("a0", "islands"));
  desk.acceptances.add("a1", {"islands"});
  desk.acceptances.add("a2", {"islands"});
  desk.acceptances.remove("a0");
  REQUIRE(desk.kept.size() == 1);
  CHECK(desk.kept.back() == Lines{"a0 islands", "a1 islands"});
  desk.answer("");
  REQUIRE(desk.kept.size() == 2);
  CHECK(desk.kept.back() == Lines{"a1 islands", "a2 islands"});
  desk.answer("");
  CHECK(desk.kept.size() == 2);
}

TEST_CASE("An acceptance that the disk does not take is told once") {
  Desk desk;
  for (const char* content : {"a", "b", "c"}) {
    desk.acceptances.add(content, {"islands"});
    desk.answer("no room");
  }
  CHECK(desk.kept.size() == 3);
  CHECK(desk.troubles == std::vector<std::string>{"no room"});
}

TEST_CASE("Of what was accepted the oldest is forgotten beyond a thousand") {
  Desk desk;
  for (int i = 0; i <= static_cast<int>(Acceptances::kMost); ++i)
    desk.acceptances.add(std::to_string(i), {"islands"});
  CHECK_FALSE(desk.acceptances.has("0", "islands"));
  CHECK(desk.acceptances.has("1", "islands"));
}

TEST_CASE("The mark of a job's contents stays when it is moved, and is another when any of its files is") {
  const Incoming spool;
  spool.put("incoming/part.stl");
  const std::string mark = spool.mark();
  CHECK_FALSE(mark.empty());
  fs::rename(spool.folder.path() / "incoming/part.stl", spool.folder.path() / "printing/part.stl");
  CHECK(spool.mark().empty());
  CHECK(content_mark(spool.folders.files_of(SpoolFolder::Printing, "part.stl")) == mark);
  fs::rename(spool.folder.path() / "printing/part.stl", spool.folder.path() / "incoming/part.stl");
  spool.put("incoming/part.json", "{}");
  const std::string with_ticket = spool.mark();
  CHECK(with_ticket != mark);
  spool.put("incoming/part.json", R"({"copies": 2})");
  CHECK(spool.mark() != with_ticket);
}

TEST_CASE("The mark of a symbolic link is that of the file behind it") {
  const Incoming spool;
  spool.put("one", "a model");
  fs::create_symlink(spool.folder.path() / "one", spool.folder.path() / "incoming/part.stl");
  const std::string mark = spool.mark();
  spool.put("one", "another model");
  CHECK(spool.mark() != mark);
}
