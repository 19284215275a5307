#include "daemon/history/history_database.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/system/sqlite.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using std::chrono::system_clock;
namespace fs = std::filesystem;

namespace {

const system_clock::time_point kThen = system_clock::time_point(1'700'000'000s);

EndedJob ended(const std::string& name, const std::string& outcome = "done", const std::string& reason = "") {
  EndedJob job{.name = name, .outcome = outcome, .reason = reason};
  job.began = kThen;
  job.ended = kThen + 1h;
  return job;
}

JobFigures used(const std::string& resin, double lit_s) {
  JobFigures figures;
  figures.resin = resin;
  figures.layers_exposed = 2;
  figures.lit_s = lit_s;
  figures.resin_ml = lit_s / 10;
  return figures;
}

class HistoryDatabaseFixture {
 public:
  HistoryDatabaseFixture() { database.open(); }
  std::vector<std::string> names(const HistoryQuery& query = {}) {
    std::vector<std::string> found;
    for (const auto& job : database.list(query).jobs)
      found.push_back(job["job"].get<std::string>() + " " + job["outcome"].get<std::string>());
    return found;
  }

 private:
  testing::TemporaryFolder folder_;

 public:
  const std::filesystem::path file = folder_.path() / "history.sqlite";
  HistoryDatabase database{file};
};

// A history's file, which a test damages.
class HistoryFileFixture {
 public:
  void end(const std::string& name) {
    use([&] { database->end(++key_, {.name = name, .outcome = "done", .reason = ""}); });
  }
  // Returns the names of all jobs, or the error.
  std::string names() {
    std::string found;
    use([&] {
      found.clear();
      for (const auto& job : database->list({}).jobs)
        found += job["job"].get<std::string>() + " ";
    });
    return trouble.empty() ? found : trouble;
  }
  void write(const std::string& text) const { std::ofstream(file, std::ios::binary) << text; }
  [[nodiscard]] std::string bytes() const {
    std::ifstream bytes(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(bytes), {}};
  }
  // Closes the file, as when contourd ends.
  void close() { database.emplace(file); }
  [[nodiscard]] fs::path aside(int number) const {
    return file.string() + ".damaged-" + std::to_string(number);
  }

 private:
  void use(const std::function<void()>& call) {
    trouble.clear();
    try {
      database->use(call);
    } catch (const std::runtime_error& error) {
      trouble = error.what();
    }
  }

  testing::TemporaryFolder folder_;
  std::int64_t key_ = 0;

 public:
  const fs::path file = folder_.path() / "history.sqlite";
  std::optional<HistoryDatabase> database{file};
  std::string trouble;  // of the last use
};

bool says(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("A job in the history keeps all its data when the file is opened again") {
  HistoryDatabaseFixture fixture;
  EndedJob job = ended("part \xff", "failed", "the lid was opened");
  job.analysis = {{"layers", 3}};
  job.figures = {.resin = "grey",
                 .settings = "slow",
                 .warnings = {"an island", "another \"one\""},
                 .height_mm = 1.5,
                 .layer_height_um = 50,
                 .layers = 30,
                 .layers_exposed = 7,
                 .print_time_s = 12.5,
                 .lit_s = 3.25,
                 .light_asked_s = 3,
                 .most_light_over_ms = 4,
                 .resin_ml = 0.5,
                 .interruptions = 1,
                 .late_steps = 2};
  fixture.database.begin(1, job.name, kThen);
  CHECK(fixture.names().empty());
  fixture.database.end(1, job);
  HistoryDatabase opened_again(fixture.file);
  opened_again.open();
  const auto found = opened_again.list({}).jobs;
  REQUIRE(found.size() == 1);
  CHECK(found[0] == history_json(job));
}

TEST_CASE("A repeated change of the history has no effect") {
  HistoryDatabaseFixture fixture;
  for (int i = 0; i < 2; ++i)
    fixture.database.begin(1, "part", kThen);
  for (int i = 0; i < 2; ++i)
    fixture.database.end(1, ended("part"));
  fixture.database.end(1, ended("part", "failed"));
  fixture.database.forget(1);
  CHECK(fixture.names() == Names{"part done"});
}

TEST_CASE("A job that was given back before it began is not in the history") {
  HistoryDatabaseFixture fixture;
  fixture.database.begin(1, "part", kThen);
  fixture.database.forget(1);
  fixture.database.adopt({});
  CHECK(fixture.names().empty());
}

TEST_CASE(
    "A job that was running when contourd died gets the outcome of the record, by its key or its name") {
  HistoryDatabaseFixture fixture;
  fixture.database.begin(1, "left", kThen);
  fixture.database.note(1, used("grey", 36));
  fixture.database.begin(2, "filed", kThen);
  fixture.database.begin(3, "lost", kThen);
  fixture.database.note(3, used("grey", 1));
  fixture.database.begin(4, "given back", kThen);
  const std::vector<JobEnd> ends{{.key = 10,
                                  .job = "left",
                                  .outcome = "failed",
                                  .reason = "interrupted",
                                  .kind = JobEnd::Kind::Interrupted},
                                 {.key = 11,
                                  .job = "unknown",
                                  .outcome = "failed",
                                  .reason = "interrupted",
                                  .kind = JobEnd::Kind::Interrupted},
                                 {.key = 2, .job = "filed", .outcome = "done"}};
  fixture.database.adopt(ends);
  const Names all{"left failed", "filed done", "lost failed", "unknown failed"};
  CHECK(fixture.names() == all);
  const auto jobs = fixture.database.list({}).jobs;
  CHECK(jobs[0]["reason"] == "interrupted");
  CHECK(jobs[0]["lit_s"] == 36);
  CHECK(jobs[2]["reason"] == HistoryDatabase::kEndNotNoted);
  // The process is killed before the record is removed.
  fixture.database.adopt(ends);
  CHECK(fixture.names() == all);
}

TEST_CASE("An end that the history has is not adopted by another job of the same name") {
  HistoryDatabaseFixture fixture;
  fixture.database.end(1, ended("part"));
  fixture.database.begin(2, "part", kThen);
  fixture.database.note(2, used("grey", 1));
  fixture.database.adopt({{.key = 1, .job = "part", .outcome = "done"}});
  CHECK(fixture.names() == Names{"part done", "part failed"});
}

TEST_CASE("A print whose beginning was not stored when contourd died appears once, by the key of its end") {
  HistoryDatabaseFixture fixture;
  fixture.database.adopt({{.key = 7, .job = "part", .outcome = "done"}});
  fixture.database.end(8, ended("other", "failed", "why"));
  fixture.database.adopt({{.key = 7, .job = "part", .outcome = "done"}});
  CHECK(fixture.names() == Names{"part done", "other failed"});
}

TEST_CASE("The history is filtered by time, outcome, resin and a part of the name") {
  HistoryDatabaseFixture fixture;
  EndedJob old = ended("old gear");
  old.ended -= 24h;
  fixture.database.end(1, old);
  fixture.database.end(2, ended("clip", "failed", "why"));
  EndedJob grey = ended("Gear");
  grey.figures.resin = "grey";
  fixture.database.end(3, grey);
  HistoryQuery query;
  query.since = kThen;
  CHECK(fixture.names(query) == Names{"clip failed", "Gear done"});
  query.outcome = "done";
  CHECK(fixture.names(query) == Names{"Gear done"});
  CHECK(fixture.names({.resin = "grey"}) == Names{"Gear done"});
  CHECK(fixture.names({.name = "gear"}) == Names{"old gear done"});
  CHECK(fixture.names({.name = "%"}).empty());
}

TEST_CASE("A page of the history has limits in jobs and bytes, and names the start of the next page") {
  HistoryDatabaseFixture fixture;
  for (int i = 1; i <= 40; ++i) {
    EndedJob job = ended(std::to_string(i), "failed", std::string(5'000, 'x'));
    job.figures.settings = std::string(5'000, 'y');
    job.figures.warnings = std::vector<std::string>(100, std::string(5'000, 'z'));
    fixture.database.end(i, job);
  }
  Names all;
  HistoryQuery query;
  int pages = 0;
  do {
    const HistoryPage page = fixture.database.list(query);
    CHECK(page.jobs.dump().size() < 100'000);
    Names names;
    for (const auto& job : page.jobs)
      names.push_back(job["job"]);
    all.insert(all.begin(), names.begin(), names.end());
    query.before = page.before;
    REQUIRE(++pages < 40);
  } while (query.before);
  REQUIRE(all.size() == 40);
  CHECK(all.front() == "1");
  CHECK(all.back() == "40");
  CHECK(pages > 2);
  CHECK(fixture.names({.last = 2}) == Names{"39 failed", "40 failed"});
}

TEST_CASE("Only the usage of the oldest jobs is kept") {
  testing::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "history.sqlite";
  HistoryDatabase(file).open();
  {
    SqliteDatabase raw(file, 0ms);
    raw.execute(
        "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<10002) "
        "INSERT INTO job(key,name,outcome,began_ms,resin,layers_exposed,lit_s,resin_ml) "
        "SELECT i,'job '||i,'done',i,'grey',2,1,0.5 FROM n");
  }
  HistoryDatabase database(file);
  database.open();
  EndedJob last = ended("last");
  last.figures = used("clear", 100);
  database.end(20'000, last);
  CHECK(SqliteDatabase(file, 0ms).integer("SELECT count(*) FROM job") == HistoryDatabase::kMostJobs);
  CHECK(SqliteDatabase(file, 0ms).text("SELECT name FROM job ORDER BY id LIMIT 1") == "job 4");
  const Usage all = database.usage();
  CHECK(all.jobs == 10'003);
  CHECK(all.layers == 2 * 10'003);
  CHECK(all.lit_s == 10'102);
  const std::vector<Usage> by_resin = database.usage_by_resin();
  REQUIRE(by_resin.size() == 2);
  CHECK(by_resin[0].resin == "grey");
  CHECK(by_resin[0].jobs == 10'002);
  CHECK(by_resin[1].resin_ml == 10);
  const std::vector<WearPartUse> wear = database.wear();
  REQUIRE(wear.size() == 3);
  CHECK(wear[1].prints == 10'003);
  CHECK(wear[1].layers == 2 * 10'003);
}

// --- the file

TEST_CASE("A history of random bytes is renamed and reported, and a new one begins") {
  HistoryFileFixture fixture;
  std::string noise(10'000, ' ');
  std::mt19937 chance(1);
  for (char& byte : noise)
    byte = static_cast<char>(chance());
  fixture.write(noise);
  fixture.end("one");
  CHECK(fixture.trouble.empty());
  CHECK(fixture.names() == "one ");
  CHECK(fs::file_size(fixture.aside(1)) == noise.size());
  const auto notes = fixture.database->take_notes();
  REQUIRE(notes.size() == 1);
  CHECK(says(notes[0], "damaged"));
  CHECK(says(notes[0], fixture.aside(1).string()));
  CHECK(fixture.database->take_notes().empty());
}

TEST_CASE("A history that is truncated or damaged in the middle is renamed, and a new one begins") {
  for (const bool cut : {true, false}) {
    CAPTURE(cut);
    HistoryFileFixture fixture;
    for (int i = 0; i < 200; ++i)
      fixture.end("a job with quite a long name " + std::to_string(i));
    fixture.close();
    const auto size = fs::file_size(fixture.file);
    REQUIRE(size > 16'384);
    if (cut) {
      fs::resize_file(fixture.file, size / 2 + 100);
    } else {
      std::fstream file(fixture.file, std::ios::binary | std::ios::in | std::ios::out);
      file.seekp(8'192);
      file << std::string(4'096, 'x');
    }
    fixture.end("after");
    CHECK(fixture.trouble.empty());
    CHECK(fixture.names() == "after ");
    CHECK(fs::exists(fixture.aside(1)));
  }
}

TEST_CASE(
    "A history whose tables have damaged definitions is renamed, and one with tables of a user is not") {
  for (const std::string column : {"height_mm REAL", "job_under_way ON", "lit_s REAL NOT NULL\n) STRICT"}) {
    CAPTURE(column);
    HistoryFileFixture fixture;
    fixture.end("one");
    fixture.close();
    SqliteDatabase(fixture.file, 0ms).execute("CREATE TABLE mine(note TEXT)");
    CHECK(fixture.names() == "one ");
    fixture.close();
    std::string bytes = fixture.bytes();
    const std::size_t at = bytes.find(column);
    REQUIRE(at != std::string::npos);
    bytes[at] = 'x';
    fixture.write(bytes);
    CHECK(fixture.names().empty());
    CHECK(fs::exists(fixture.aside(1)));
  }
}

TEST_CASE("An empty file becomes a history") {
  HistoryFileFixture fixture;
  fixture.write("");
  fixture.end("one");
  CHECK(fixture.names() == "one ");
  CHECK_FALSE(fs::exists(fixture.aside(1)));
}

TEST_CASE("The write-ahead log of a killed contourd is in the history after the next start") {
  HistoryFileFixture killed;
  killed.end("one");
  const fs::path wal = killed.file.string() + "-wal";
  REQUIRE(fs::file_size(wal) > 0);
  HistoryFileFixture next;
  fs::copy_file(killed.file, next.file);
  fs::copy_file(wal, next.file.string() + "-wal");
  CHECK(next.names() == "one ");
}

TEST_CASE("The write-ahead log of a damaged history is not applied to the new one") {
  HistoryFileFixture fixture;
  fixture.write(std::string(8'192, 'x'));
  const fs::path wal = fixture.file.string() + "-wal";
  std::ofstream(wal) << "what was not in it yet";
  CHECK(fixture.names().empty());
  CHECK(fs::exists(fixture.aside(1)));
}

TEST_CASE("At most nine damaged histories are kept") {
  HistoryFileFixture fixture;
  for (int i = 1; i <= 11; ++i) {
    fixture.close();
    fixture.write("no history " + std::to_string(i) + std::string(1'000, ' '));
    fixture.end("one");
    CHECK(fixture.names() == "one ");
  }
  CHECK(fs::exists(fixture.aside(9)));
  CHECK_FALSE(fs::exists(fixture.aside(10)));
}

TEST_CASE("The history of a later version is reported and left alone, and does not count as damaged") {
  HistoryFileFixture fixture;
  fixture.end("one");
  fixture.close();
  SqliteDatabase(fixture.file, 0ms).execute("PRAGMA user_version=99");
  fixture.end("two");
  CHECK(says(fixture.trouble, "its version is 99, and this contourd reads version 1"));
  CHECK_FALSE(fs::exists(fixture.aside(1)));
  CHECK(SqliteDatabase(fixture.file, 0ms).integer("PRAGMA user_version") == 99);
}

TEST_CASE("A new history begins if a user removes the file") {
  HistoryFileFixture fixture;
  fixture.end("one");
  fs::rename(fixture.file, fixture.file.string() + ".backup");
  fs::rename(fixture.file.string() + "-wal", fixture.file.string() + ".backup-wal");
  fixture.end("two");
  CHECK(fixture.names() == "two ");
}
