#include "daemon/history/history_store.hpp"

#include <sys/stat.h>

#include <fstream>
#include <random>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

class HistoryStoreFixture {
 public:
  void end(const std::string& name) {
    store.change([key = ++key_, name](HistoryDatabase& database) {
      database.end(key, {.name = name, .outcome = "done", .reason = ""});
    });
  }
  // Returns the names of all jobs, or the error.
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
  // Closes the file, as when contourd ends.
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

TEST_CASE("A history of random bytes is renamed and reported, and a new one begins") {
  HistoryStoreFixture fixture;
  std::string noise(10'000, ' ');
  std::mt19937 chance(1);
  for (char& byte : noise)
    byte = static_cast<char>(chance());
  fixture.write(noise);
  fixture.end("one");
  CHECK(fixture.store.trouble().empty());
  CHECK(fixture.names() == "one ");
  CHECK(fs::file_size(fixture.aside(1)) == noise.size());
  const auto notes = fixture.store.take_notes();
  REQUIRE(notes.size() == 1);
  CHECK(says(notes[0], "damaged"));
  CHECK(says(notes[0], fixture.aside(1).string()));
  CHECK(fixture.store.take_notes().empty());
}

TEST_CASE("A history that is truncated or damaged in the middle is renamed, and a new one begins") {
  for (const bool cut : {true, false}) {
    CAPTURE(cut);
    HistoryStoreFixture fixture;
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
    CHECK(fixture.store.trouble().empty());
    CHECK(fixture.names() == "after ");
    CHECK(fs::exists(fixture.aside(1)));
  }
}

TEST_CASE("An empty file becomes a history") {
  HistoryStoreFixture fixture;
  fixture.write("");
  fixture.end("one");
  CHECK(fixture.names() == "one ");
  CHECK_FALSE(fs::exists(fixture.aside(1)));
}

TEST_CASE("The write-ahead log of a killed contourd is in the history after the next start") {
  HistoryStoreFixture killed;
  killed.end("one");
  const fs::path wal = killed.file.string() + "-wal";
  REQUIRE(fs::file_size(wal) > 0);
  HistoryStoreFixture next;
  fs::copy_file(killed.file, next.file);
  fs::copy_file(wal, next.file.string() + "-wal");
  CHECK(next.names() == "one ");
}

TEST_CASE("The write-ahead log of a damaged history is not applied to the new one") {
  HistoryStoreFixture fixture;
  fixture.write(std::string(8'192, 'x'));
  const fs::path wal = fixture.file.string() + "-wal";
  std::ofstream(wal) << "what was not in it yet";
  CHECK(fixture.names().empty());
  CHECK(fs::exists(fixture.aside(1)));
}

TEST_CASE("At most nine damaged histories are kept") {
  HistoryStoreFixture fixture;
  for (int i = 1; i <= 11; ++i) {
    fixture.close();
    fixture.write("no history " + std::to_string(i) + std::string(1'000, ' '));
    fixture.end("one");
    CHECK(fixture.names() == "one ");
  }
  CHECK(fs::exists(fixture.aside(9)));
  CHECK_FALSE(fs::exists(fixture.aside(10)));
}

TEST_CASE("A history that is a folder, a link or a pipe is reported and left alone, and its changes wait") {
  for (const std::string what : {"is a folder", "is a link, which is not followed", "is not a file"}) {
    CAPTURE(what);
    HistoryStoreFixture fixture;
    const fs::path target = fixture.file.string() + ".target";
    if (what == "is a folder") {
      fs::create_directory(fixture.file);
    } else if (what == "is not a file") {
      REQUIRE(::mkfifo(fixture.file.c_str(), 0600) == 0);
    } else {
      fs::create_symlink(target, fixture.file);
    }
    fixture.end("one");
    CHECK(says(fixture.store.trouble(), "history.sqlite " + what));
    CHECK(fixture.store.waits());
    CHECK(says(fixture.names(), what));
    CHECK_FALSE(fs::exists(target));
    CHECK_FALSE(fs::exists(fs::symlink_status(fixture.aside(1))));
    fs::remove(fixture.file);
    fixture.end("two");
    CHECK(fixture.store.trouble().empty());
    CHECK_FALSE(fixture.store.waits());
    CHECK(fixture.names() == "one two ");
  }
}

TEST_CASE("The history of a later version is reported and left alone, and does not count as damaged") {
  HistoryStoreFixture fixture;
  fixture.end("one");
  fixture.close();
  SqliteDatabase(fixture.file, 0ms).execute("PRAGMA user_version=99");
  fixture.end("two");
  CHECK(says(fixture.store.trouble(), "its version is 99, and this contourd reads version 1"));
  CHECK_FALSE(fs::exists(fixture.aside(1)));
}

TEST_CASE("Changes of a history that another program has locked are made when the lock is gone") {
  HistoryStoreFixture fixture;
  fixture.end("one");
  {
    SqliteDatabase shell(fixture.file, 0ms);
    const SqliteTransaction transaction(shell);
    fixture.end("two");
    CHECK(says(fixture.store.trouble(), "another program has locked it"));
    CHECK(fixture.store.waits());
  }
  fixture.store.retry();
  CHECK(fixture.store.trouble().empty());
  CHECK(fixture.names() == "one two ");
}

TEST_CASE("A new history begins if a user removes the file") {
  HistoryStoreFixture fixture;
  fixture.end("one");
  fs::rename(fixture.file, fixture.file.string() + ".backup");
  fs::rename(fixture.file.string() + "-wal", fixture.file.string() + ".backup-wal");
  fixture.end("two");
  CHECK(fixture.names() == "two ");
}

TEST_CASE("The latest thousand changes that cannot be made wait") {
  HistoryStoreFixture fixture;
  fs::create_directory(fixture.file);
  for (std::size_t i = 0; i < HistoryStore::kMostWaiting + 2; ++i)
    fixture.end(std::to_string(i));
  fixture.store.change_now_or_never([](HistoryDatabase& database) {
    database.end(-1, {.name = "never", .outcome = "done", .reason = ""});
  });
  fs::remove(fixture.file);
  fixture.store.retry();
  CHECK(SqliteDatabase(fixture.file, 0ms).integer("SELECT count(*) FROM job") == 1'000);
  CHECK(SqliteDatabase(fixture.file, 0ms).text("SELECT name FROM job ORDER BY id LIMIT 1") == "2");
}
