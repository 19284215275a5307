#include "daemon/jobs/acceptances.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/fake_printer.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"

namespace fs = std::filesystem;

namespace {

class AcceptancesFixture {
 public:
  EventLoop loop;
  testing::LogText log{loop};
  testing::FakeChecks work;
  Acceptances acceptances{work, log.log};
};

class ContentMarkFixture : public testing::SpoolFixture {
 public:
  [[nodiscard]] std::string mark() const {
    return content_mark(folders.files_of(SpoolFolder::Incoming, "part.stl"));
  }
};

}  // namespace

TEST_CASE_METHOD(AcceptancesFixture, "An acceptance is valid for its findings and content only") {
  acceptances.add("a1", {"islands", "cracks"});
  CHECK(acceptances.has("a1", "islands"));
  CHECK(acceptances.has("a1", "cracks"));
  CHECK_FALSE(acceptances.has("a1", "empty_layers"));
  CHECK_FALSE(acceptances.has("a2", "islands"));
  acceptances.remove("a1");
  CHECK_FALSE(acceptances.has("a1", "islands"));
}

TEST_CASE_METHOD(AcceptancesFixture,
                 "Acceptances are saved for the next process, one write at a time and the latest last") {
  acceptances.load({"a0 islands"});
  CHECK(acceptances.has("a0", "islands"));
  acceptances.add("a1", {"islands"});
  acceptances.add("a2", {"islands"});
  acceptances.remove("a0");
  REQUIRE(work.saved.size() == 1);
  CHECK(work.saved.back() == Names{"a0 islands", "a1 islands"});
  work.save_done("");
  REQUIRE(work.saved.size() == 2);
  CHECK(work.saved.back() == Names{"a1 islands", "a2 islands"});
  work.save_done("");
  CHECK(work.saved.size() == 2);
}

TEST_CASE_METHOD(AcceptancesFixture, "A failure to save an acceptance is reported once") {
  for (const char* content : {"a", "b", "c"}) {
    acceptances.add(content, {"islands"});
    work.save_done("no room");
  }
  CHECK(work.saved.size() == 3);
  CHECK(log.count("warning: cannot save what was accepted; it must be confirmed again after a restart: "
                  "no room") == 1);
}

TEST_CASE_METHOD(AcceptancesFixture, "The oldest acceptance is forgotten beyond a thousand") {
  for (int i = 0; i <= static_cast<int>(Acceptances::kMaxLines); ++i)
    acceptances.add(std::to_string(i), {"islands"});
  CHECK_FALSE(acceptances.has("0", "islands"));
  CHECK(acceptances.has("1", "islands"));
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
