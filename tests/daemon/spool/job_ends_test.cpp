#include "daemon/spool/job_ends.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "daemon/spool/copied_originals.hpp"
#include "daemon/spool/job_moves.hpp"
#include "daemon/spool/spool.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

const JobEnd kDone{
    .key = 1, .job = "part", .outcome = "done", .ended = std::chrono::system_clock::time_point(5s)};

class JobEndsFixture {
 public:
  // Returns the record as the next process reads it.
  [[nodiscard]] JobEndRecord next() const { return JobEndRecord(records); }
  // Makes every attempt to write the record fail.
  void obstruct() const {
    fs::remove(file);
    fs::create_directories(file / "full");
  }

  testing::TemporaryFolder folder;
  const fs::path file = folder.path() / "ended-jobs";
  const StateRecords records{folder.path()};
  JobEndRecord ends{records};
};

// A spool on which a process was killed while it moved a refused job to failed/.
class CutRejection {
 public:
  CutRejection() {
    fs::create_directories(incoming);
    fs::create_directories(failed);
    make_state_folder(state_folder_path(root));
    put_job();
    const JobFiles job = SpoolFolders(root).files_of(SpoolFolder::Incoming, "part.stl");
    JobEndRecord(records).add({.key = 1,
                               .job = "part-2",
                               .outcome = "failed",
                               .reason = "no model",
                               .file = "part.stl",
                               .mark = mark_of(job),
                               .changed_ns = change_time(job.model)});
  }
  // Puts a model with an older ticket into incoming/.
  void put_job() const {
    write(incoming / "part.json", "{}");
    // The kernel's clock for files ticks every few milliseconds.
    do
      write(incoming / "part.stl", "a model");
    while (change_time(incoming / "part.json") >= change_time(incoming / "part.stl"));
  }
  static void write(const fs::path& path, std::string_view text) { std::ofstream(path) << text; }
  [[nodiscard]] std::string reason() const {
    std::ifstream file(failed / "part-2.reason.txt");
    return {std::istreambuf_iterator<char>(file), {}};
  }
  [[nodiscard]] std::int64_t refused_at() const { return JobEndRecord(records).pending()[0].end.changed_ns; }
  // Starts the next process, and returns true if the end waits for no files then.
  bool restart() {
    Spool spool(root, loop, observer);
    const std::vector<JobEndRecord::Pending> pending = spool.ends().pending();
    return pending.size() == 1 && !pending[0].awaits(EndConsumer::Files);
  }

  testing::TemporaryFolder folder;
  const fs::path root = folder.path() / "spool", incoming = root / "incoming", failed = root / "failed";
  const StateRecords records{state_folder_path(root)};
  EventLoop loop;
  testing::NoSpoolObserver observer;
};

}  // namespace

TEST_CASE("An end survives a restart until every consumer has it") {
  JobEndsFixture fixture;
  fixture.ends.add({.key = 1,
                    .job = "b\xE4r\n2",
                    .outcome = "failed",
                    .reason = "the sky fell",
                    .ended = std::chrono::system_clock::time_point(5s),
                    .kind = JobEnd::Kind::Interrupted});
  const std::optional<JobEnd> end = fixture.next().end_of("b\xE4r\n2");
  REQUIRE(end);
  CHECK(end->key == 1);
  CHECK(end->outcome == "failed");
  CHECK(end->reason == "the sky fell");
  CHECK(end->ended == std::chrono::system_clock::time_point(5s));
  CHECK(end->kind == JobEnd::Kind::Interrupted);
  fixture.ends.files_taken("b\xE4r\n2");
  fixture.ends.taken(1, EndConsumer::Notice);
  CHECK(fixture.next().pending().size() == 1);
  fixture.ends.taken(1, EndConsumer::History);
  CHECK(fixture.next().pending().empty());
  CHECK_FALSE(fs::exists(fixture.file));
}

TEST_CASE("A long reason is shortened once, however many processes read and write it") {
  JobEndsFixture fixture;
  JobEnd end = kDone;
  end.reason = std::string(2000, 'a');
  fixture.ends.add(end);
  const std::string first = fixture.next().pending().at(0).end.reason;
  CHECK(first == std::string(960, 'a') + "... (1040 bytes more)");
  JobEndRecord next = fixture.next();
  next.add({.key = 2, .job = "other", .outcome = "done"});
  CHECK(fixture.next().pending().at(0).end.reason == first);
}

TEST_CASE("An end that the disk does not accept is written with the next one") {
  JobEndsFixture fixture;
  fixture.obstruct();
  CHECK_THROWS_AS(fixture.ends.add(kDone), std::system_error);
  CHECK(fixture.ends.end_of("part"));
  fs::remove_all(fixture.file);
  fixture.ends.add(kDone);
  CHECK(fixture.next().end_of("part"));
  CHECK(fixture.next().pending().size() == 1);
}

TEST_CASE("A job that gets the name of an ended one has no end, which the disk must know") {
  JobEndsFixture fixture;
  fixture.ends.add(kDone);
  fixture.obstruct();
  CHECK_THROWS_AS(fixture.ends.release_name("part"), std::system_error);
  fs::remove_all(fixture.file);
  fixture.ends.release_name("part");
  CHECK_FALSE(fixture.next().end_of("part"));
  CHECK(fixture.next().pending()[0].awaits(EndConsumer::History));
}

TEST_CASE("A full disk keeps no name from a job if the record on the disk does not have the name") {
  JobEndsFixture fixture;
  fixture.obstruct();
  CHECK_THROWS_AS(fixture.ends.add(kDone), std::system_error);
  CHECK_NOTHROW(fixture.ends.release_name("other"));
  CHECK_NOTHROW(fixture.ends.release_name("part"));
  CHECK_FALSE(fixture.ends.end_of("part"));
}

TEST_CASE("A dropped end is forgotten, and the oldest end beyond the limit") {
  JobEndsFixture fixture;
  for (std::size_t key = 1; key <= JobEndRecord::kMost + 1; ++key)
    fixture.ends.add({.key = static_cast<std::int64_t>(key), .job = "part", .outcome = "done"});
  CHECK(fixture.next().pending().size() == JobEndRecord::kMost);
  CHECK(fixture.next().pending()[0].end.key == 2);
  fixture.ends.drop(2);
  CHECK(fixture.next().pending()[0].end.key == 3);
}

TEST_CASE("A damaged record gives only the ends that are valid") {
  JobEndsFixture fixture;
  fixture.ends.add(kDone);
  fixture.ends.add({.key = 2, .job = "other", .outcome = "done"});
  const std::vector<std::string> fields = fixture.records.job_ends();
  const std::size_t size = fields.size() / 2;
  const auto read = [&](std::size_t field, const std::string& text) {
    std::vector<std::string> damaged = fields;
    damaged[field] = text;
    fixture.records.keep_job_ends(damaged);
    return fixture.next().pending().size();
  };
  CHECK(read(0, "1") == 2);
  for (const std::string key : {"", "0", "1x", "99999999999999999999"})
    CHECK(read(0, key) == 1);
  for (const std::string job : {"", "..", "a/b"})
    CHECK(read(1, job) == 1);
  CHECK(read(2, "splendid") == 1);
  CHECK(read(4, "9223372036854") == 2);
  for (const std::string ended_ms : {"-1", "9223372036855"})
    CHECK(read(4, ended_ms) == 1);
  fixture.records.keep_job_ends({fields.begin(), fields.begin() + static_cast<std::ptrdiff_t>(size + 1)});
  CHECK(fixture.next().pending().size() == 1);
}

TEST_CASE("A refused job that was not moved when contourd was killed is moved at the next start") {
  CutRejection cut;
  CHECK(cut.restart());
  CHECK(fs::exists(cut.failed / "part-2.stl"));
  CHECK(fs::exists(cut.failed / "part-2.json"));
  CHECK(fs::is_empty(cut.incoming));
  CHECK(cut.reason() == "no model\n");
}

TEST_CASE("A refused model that a user has moved back to incoming/ stays there") {
  CutRejection cut;
  do {
    fs::rename(cut.incoming / "part.stl", cut.failed / "part-2.stl");
    fs::rename(cut.failed / "part-2.stl", cut.incoming / "part.stl");
  } while (change_time(cut.incoming / "part.stl") == cut.refused_at());
  CHECK(cut.restart());
  CHECK(fs::exists(cut.incoming / "part.stl"));
  CHECK(fs::exists(cut.incoming / "part.json"));
}

TEST_CASE("The ticket of a refused job follows its model at the next start, under the model's new name") {
  CutRejection cut;
  fs::rename(cut.incoming / "part.stl", cut.failed / "part-2.stl");
  CHECK(cut.restart());
  CHECK(fs::exists(cut.failed / "part-2.json"));
  CHECK(fs::is_empty(cut.incoming));
}

TEST_CASE("A model or a ticket that a user has put into incoming/ after a refusal stays there") {
  CutRejection cut;
  SECTION("a model in place of the refused one") {
    fs::remove(cut.incoming / "part.stl");
    CutRejection::write(cut.failed / "keeps the inode of the refused model", "");
    CutRejection::write(cut.incoming / "part.stl", "another model");
    CHECK(cut.restart());
    CHECK(fs::exists(cut.incoming / "part.stl"));
  }
  SECTION("a ticket after the model was moved") {
    fs::rename(cut.incoming / "part.stl", cut.failed / "part-2.stl");
    const std::int64_t moved = change_time(cut.failed / "part-2.stl");
    do
      CutRejection::write(cut.incoming / "part.json", "{ }");
    while (change_time(cut.incoming / "part.json") <= moved);
    CHECK(cut.restart());
  }
  CHECK(fs::exists(cut.incoming / "part.json"));
  CHECK_FALSE(fs::exists(cut.failed / "part-2.json"));
}

TEST_CASE("The ticket of a job that got another name follows its model to printing/ at the next start") {
  CutRejection cut;
  CutRejection::write(cut.failed / "part.stl", "an earlier job");
  const fs::path printing = cut.root / "printing", ticket = cut.incoming / "part.json";
  {
    Spool spool(cut.root, cut.loop, cut.observer);
    cut.put_job();
    CHECK(spool.begin("part.stl").name == "part-3");
  }
  // The state of a process that was killed between the two moves: the model's time is after the ticket's.
  fs::rename(printing / "part-3.json", ticket);
  do
    fs::permissions(printing / "part-3.stl", fs::perms::owner_all);
  while (change_time(printing / "part-3.stl") <= change_time(ticket));
  Spool spool(cut.root, cut.loop, cut.observer);
  const std::vector<JobFiles> left = spool.interrupted();
  REQUIRE(left.size() == 1);
  CHECK(left[0].ticket);
  CHECK_FALSE(fs::exists(ticket));
}
