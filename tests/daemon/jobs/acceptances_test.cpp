#include "daemon/jobs/acceptances.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"

using Lines = Acceptances::Lines;
namespace fs = std::filesystem;

namespace {

class AcceptancesFixture {
 public:
  std::vector<Lines> kept;
  std::function<void(const std::string&)> answer;  // ends the last save
  std::vector<std::string> troubles;
  Acceptances acceptances{[this](const Lines& lines, auto done) {
                            kept.push_back(lines);
                            answer = std::move(done);
                          },
                          [this](const std::string& trouble) { troubles.push_back(trouble); }};
};

class ContentMarkFixture : public testing::SpoolFixture {
 public:
  [[nodiscard]] std::string mark() const {
    return content_mark(folders.files_of(SpoolFolder::Incoming, "part.stl"));
  }
};

}  // namespace

TEST_CASE("An acceptance is valid for its findings and content only") {
  AcceptancesFixture fixture;
  fixture.acceptances.add("a1", {"islands", "cracks"});
  CHECK(fixture.acceptances.has("a1", "islands"));
  CHECK(fixture.acceptances.has("a1", "cracks"));
  CHECK_FALSE(fixture.acceptances.has("a1", "empty_layers"));
  CHECK_FALSE(fixture.acceptances.has("a2", "islands"));
  fixture.acceptances.remove("a1");
  CHECK_FALSE(fixture.acceptances.has("a1", "islands"));
}

TEST_CASE("Acceptances are saved for the next process, one write at a time and the latest last") {
  AcceptancesFixture fixture;
  fixture.acceptances.load({"a0 islands"});
  CHECK(fixture.acceptances.has("a0", "islands"));
  fixture.acceptances.add("a1", {"islands"});
  fixture.acceptances.add("a2", {"islands"});
  fixture.acceptances.remove("a0");
  REQUIRE(fixture.kept.size() == 1);
  CHECK(fixture.kept.back() == Lines{"a0 islands", "a1 islands"});
  fixture.answer("");
  REQUIRE(fixture.kept.size() == 2);
  CHECK(fixture.kept.back() == Lines{"a1 islands", "a2 islands"});
  fixture.answer("");
  CHECK(fixture.kept.size() == 2);
}

TEST_CASE("A failure to save an acceptance is reported once") {
  AcceptancesFixture fixture;
  for (const char* content : {"a", "b", "c"}) {
    fixture.acceptances.add(content, {"islands"});
    fixture.answer("no room");
  }
  CHECK(fixture.kept.size() == 3);
  CHECK(fixture.troubles == std::vector<std::string>{"no room"});
}

TEST_CASE("The oldest acceptance is forgotten beyond a thousand") {
  AcceptancesFixture fixture;
  for (int i = 0; i <= static_cast<int>(Acceptances::kMost); ++i)
    fixture.acceptances.add(std::to_string(i), {"islands"});
  CHECK_FALSE(fixture.acceptances.has("0", "islands"));
  CHECK(fixture.acceptances.has("1", "islands"));
}

TEST_CASE("The mark of a job's content stays when the job is moved, and changes when any of its files does") {
  const ContentMarkFixture spool;
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

TEST_CASE("The mark of a symbolic link is the mark of its target") {
  const ContentMarkFixture spool;
  spool.put("one", "a model");
  fs::create_symlink(spool.folder.path() / "one", spool.folder.path() / "incoming/part.stl");
  const std::string mark = spool.mark();
  spool.put("one", "another model");
  CHECK(spool.mark() != mark);
}
