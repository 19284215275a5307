#include "daemon/system/sqlite.hpp"

#include <chrono>
#include <string>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

class Bench {
 public:
  Bench() { database.execute("CREATE TABLE thing(number INTEGER, size REAL, name TEXT)"); }
  std::int64_t count() { return database.integer("SELECT count(*) FROM thing"); }

 private:
  testing::TemporaryFolder folder_;

 public:
  const std::filesystem::path file = folder_.path() / "things.sqlite";
  SqliteDatabase database{file, 0ms};
};

int code_of(SqliteDatabase& database, const std::string& sql) {
  try {
    database.execute(sql);
  } catch (const SqliteError& error) {
    return error.code();
  }
  return SQLITE_OK;
}

}  // namespace

TEST_CASE("What is bound to an SQLite statement comes back, whatever a text is made of") {
  Bench bench;
  const std::string name = "'; DROP TABLE thing; -- \xff\x01";
  SqliteStatement(bench.database, "INSERT INTO thing VALUES(?,?,?)")
      .bind(std::int64_t{-7'000'000'000}, 0.25, name)
      .step();
  CHECK(bench.database.changes() == 1);
  SqliteStatement row(bench.database, "SELECT number,size,name,NULL FROM thing");
  REQUIRE(row.step());
  CHECK(row.integer(0) == -7'000'000'000);
  CHECK(row.real(1) == 0.25);
  CHECK(row.text(2) == name);
  CHECK(row.text(3).empty());
  CHECK_FALSE(row.step());
  CHECK(bench.database.text("SELECT name FROM thing WHERE number=0").empty());
}

TEST_CASE("An SQLite transaction that is not committed leaves nothing") {
  Bench bench;
  {
    SqliteTransaction transaction(bench.database);
    bench.database.execute("INSERT INTO thing VALUES(1,1,'')");
  }
  CHECK(bench.count() == 0);
  SqliteTransaction transaction(bench.database);
  bench.database.execute("INSERT INTO thing VALUES(1,1,'')");
  transaction.commit();
  CHECK(bench.count() == 1);
}

TEST_CASE("SQLite's errors come with their code: bad SQL, a lock, no folder") {
  Bench bench;
  CHECK(code_of(bench.database, "SELEKT 1") == SQLITE_ERROR);
  CHECK_THROWS_AS(SqliteStatement(bench.database, "SELECT nothing FROM thing"), SqliteError);
  SqliteDatabase other(bench.file, 0ms);
  const SqliteTransaction transaction(other);
  CHECK(code_of(bench.database, "BEGIN IMMEDIATE") == SQLITE_BUSY);
  try {
    const SqliteDatabase nowhere(bench.file / "things.sqlite", 0ms);
    FAIL("opened");
  } catch (const SqliteError& error) {
    CHECK(error.code() == SQLITE_CANTOPEN);
    CHECK_FALSE(error.is_corruption());
  }
}

TEST_CASE("An SQLite statement without end is ended by its limit of time, and the next one goes on") {
  Bench bench;
  const std::string endless =
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n) SELECT count(*) FROM n";
  {
    const SqliteTimeLimit limit(bench.database, 1ms);
    CHECK(code_of(bench.database, endless) == SQLITE_INTERRUPT);
  }
  CHECK(bench.database.integer("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<100000) "
                               "SELECT count(*) FROM n") == 100'000);
}
