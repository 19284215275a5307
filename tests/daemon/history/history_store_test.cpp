#include "daemon/history/history_store.hpp"

#include <sys/stat.h>

#include <fstream>
#include <random>
#include <string>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

class Bench {
 public:
  void end(const std::string& name) {
    store.change([key = ++key_, name](HistoryDatabase& database) {
      database.end(key, {.name = name, .outcome = "done", .reason = ""});
    });
  }
  // Names of all jobs; what is wrong where they cannot be told.
  std::string names() {
    std::string found;
    try {
      store.ask([&found](HistoryDatabase& database) {
        found.clear();
        for (const auto& job : database.list({}).jobs)
          found += job["job"].get<std::string>() + " ";
      });
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return found;
  }
  void write(const std::string& text) const { std::ofstream(file, std::ios::binary) << text; }
  // Closed, as by a contourd that ended.
  void close() { store = HistoryStore(file); }
  [[nodiscard]] fs::path aside(int number) const {
    return file.string() + ".damaged-" + std::to_string(number);
  }

 private:
  testing::TemporaryFolder folder_;
  std::int64_t key_ = 0;

 public:
  const fs::path file = folder_.path() / "history.sqlite";
  HistoryStore store{file};
};

bool says(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("A history of random bytes is put aside, told, and begun anew") {
  Bench bench;
  std::string noise(10'000, ' ');
  std::mt19937 chance(1);
  for (char& byte : noise)
    byte = static_cast<char>(chance());
  bench.write(noise);
  bench.end("one");
  CHECK(bench.store.trouble().empty());
  CHECK(bench.names() == "one ");
  CHECK(fs::file_size(bench.aside(1)) == noise.size());
  const auto notes = bench.store.take_notes();
  REQUIRE(notes.size() == 1);
  CHECK(says(notes[0], "damaged"));
  CHECK(says(notes[0], bench.aside(1).string()));
  CHECK(bench.store.take_notes().empty());
}

TEST_CASE("A history that was cut short, or damaged in its middle, is put aside and begun anew") {
  for (const bool cut : {true, false}) {
    CAPTURE(cut);
    Bench bench;
    for (int i = 0; i < 200; ++i)
      bench.end("a job with quite a long name " + std::to_string(i));
    bench.close();
    const auto size = fs::file_size(bench.file);
    REQUIRE(size > 16'384);
    if (cut) {
      fs::resize_file(bench.file, size / 2 + 100);
    } else {
      std::fstream file(bench.file, std::ios::binary | std::ios::in | std::ios::out);
      file.seekp(8'192);
      file << std::string(4'096, 'x');
    }
    bench.end("after");
    CHECK(bench.store.trouble().empty());
    CHECK(bench.names() == "after ");
    CHECK(fs::exists(bench.aside(1)));
  }
}

TEST_CASE("An empty file becomes a history") {
  Bench bench;
  bench.write("");
  bench.end("one");
  CHECK(bench.names() == "one ");
  CHECK_FALSE(fs::exists(bench.aside(1)));
}

TEST_CASE("What a killed contourd left beside the history is in it at the next start") {
  Bench killed;
  killed.end("one");
  const fs::path wal = killed.file.string() + "-wal";
  REQUIRE(fs::file_size(wal) > 0);
  Bench next;
  fs::copy_file(killed.file, next.file);
  fs::copy_file(wal, next.file.string() + "-wal");
  CHECK(next.names() == "one ");
}

TEST_CASE("What belongs to a damaged history does not come into the new one") {
  Bench bench;
  bench.write(std::string(8'192, 'x'));
  const fs::path wal = bench.file.string() + "-wal";
  std::ofstream(wal) << "what was not in it yet";
  CHECK(bench.names().empty());
  CHECK(fs::exists(bench.aside(1)));
}

TEST_CASE("Damaged histories are kept beside each other, and no more than nine") {
  Bench bench;
  for (int i = 1; i <= 11; ++i) {
    bench.close();
    bench.write("no history " + std::to_string(i) + std::string(1'000, ' '));
    bench.end("one");
    CHECK(bench.names() == "one ");
  }
  CHECK(fs::exists(bench.aside(9)));
  CHECK_FALSE(fs::exists(bench.aside(10)));
}

TEST_CASE(
    "A history that is a folder, a link or a pipe is told and left, and what it lacks is kept until it can "
    "be had") {
  for (const std::string what : {"is a folder", "is a link, which is not followed", "is no file"}) {
    CAPTURE(what);
    Bench bench;
    const fs::path target = bench.file.string() + ".target";
    if (what == "is a folder") {
      fs::create_directory(bench.file);
    } else if (what == "is no file") {
      REQUIRE(::mkfifo(bench.file.c_str(), 0600) == 0);
    } else {
      fs::create_symlink(target, bench.file);
    }
    bench.end("one");
    CHECK(says(bench.store.trouble(), "history.sqlite " + what));
    CHECK(bench.store.waits());
    CHECK(says(bench.names(), what));
    CHECK_FALSE(fs::exists(target));
    CHECK_FALSE(fs::exists(fs::symlink_status(bench.aside(1))));
    fs::remove(bench.file);
    bench.end("two");
    CHECK(bench.store.trouble().empty());
    CHECK_FALSE(bench.store.waits());
    CHECK(bench.names() == "one two ");
  }
}

TEST_CASE("A history of a later version is told and left, and is no damaged one") {
  Bench bench;
  bench.end("one");
  bench.close();
  SqliteDatabase(bench.file, 0ms).execute("PRAGMA user_version=99");
  bench.end("two");
  CHECK(says(bench.store.trouble(), "it is of version 99, and this contourd knows version 2"));
  CHECK_FALSE(fs::exists(bench.aside(1)));
}

TEST_CASE("What a history locked by another program lacks is in it when the lock is gone") {
  Bench bench;
  bench.end("one");
  {
    SqliteDatabase shell(bench.file, 0ms);
    const SqliteTransaction transaction(shell);
    bench.end("two");
    CHECK(says(bench.store.trouble(), "another program has it locked"));
    CHECK(bench.store.waits());
  }
  bench.store.retry();
  CHECK(bench.store.trouble().empty());
  CHECK(bench.names() == "one two ");
}

TEST_CASE("A history that its owner takes away is begun anew") {
  Bench bench;
  bench.end("one");
  fs::rename(bench.file, bench.file.string() + ".backup");
  fs::rename(bench.file.string() + "-wal", bench.file.string() + ".backup-wal");
  bench.end("two");
  CHECK(bench.names() == "two ");
}

TEST_CASE("Of changes that cannot be made, the latest thousand wait") {
  Bench bench;
  fs::create_directory(bench.file);
  for (std::size_t i = 0; i < HistoryStore::kMostWaiting + 2; ++i)
    bench.end(std::to_string(i));
  bench.store.change_now_or_never([](HistoryDatabase& database) {
    database.end(-1, {.name = "never", .outcome = "done", .reason = ""});
  });
  fs::remove(bench.file);
  bench.store.retry();
  CHECK(SqliteDatabase(bench.file, 0ms).integer("SELECT count(*) FROM job") == 1'000);
  CHECK(SqliteDatabase(bench.file, 0ms).text("SELECT name FROM job ORDER BY id LIMIT 1") == "2");
}
