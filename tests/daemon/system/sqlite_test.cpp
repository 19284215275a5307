#include "daemon/system/sqlite.hpp"

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace {

class DatabaseFixture {
 public:
  DatabaseFixture() { database.execute("CREATE TABLE thing(number INTEGER, size REAL, name TEXT)"); }
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

TEST_CASE_METHOD(DatabaseFixture,
                 "Values bound to an SQLite statement come back unchanged, also texts of any bytes") {
  const std::string name = "'; DROP TABLE thing; -- \xff\x01";
  SqliteStatement(database, "INSERT INTO thing VALUES(?,?,?)")
      .bind(std::int64_t{-7'000'000'000}, 0.25, name)
      .step();
  CHECK(database.changes() == 1);
  SqliteStatement row(database, "SELECT number,size,name,NULL FROM thing");
  REQUIRE(row.step());
  CHECK(row.integer(0) == -7'000'000'000);
  CHECK(row.real(1) == 0.25);
  CHECK(row.text(2) == name);
  CHECK(row.text(3).empty());
  CHECK_FALSE(row.step());
  CHECK(database.text("SELECT name FROM thing WHERE number=0").empty());
}

TEST_CASE_METHOD(DatabaseFixture, "An SQLite transaction that is not committed changes nothing") {
  {
    SqliteTransaction transaction(database);
    database.execute("INSERT INTO thing VALUES(1,1,'')");
  }
  CHECK(count() == 0);
  SqliteTransaction transaction(database);
  database.execute("INSERT INTO thing VALUES(1,1,'')");
  transaction.commit();
  CHECK(count() == 1);
}

TEST_CASE_METHOD(DatabaseFixture, "SQLite's errors keep their code: invalid SQL, a lock, a missing folder") {
  CHECK(code_of(database, "SELEKT 1") == SQLITE_ERROR);
  CHECK_THROWS_AS(SqliteStatement(database, "SELECT nothing FROM thing"), SqliteError);
  SqliteDatabase other(file, 0ms);
  const SqliteTransaction transaction(other);
  CHECK(code_of(database, "BEGIN IMMEDIATE") == SQLITE_BUSY);
  try {
    const SqliteDatabase nowhere(file / "things.sqlite", 0ms);
    FAIL("opened");
  } catch (const SqliteError& error) {
    CHECK(error.code() == SQLITE_CANTOPEN);
    CHECK_FALSE(error.is_corruption());
  }
}

TEST_CASE_METHOD(DatabaseFixture,
                 "An endless SQLite statement is interrupted at its time limit, and the next one runs") {
  const std::string endless =
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n) SELECT count(*) FROM n";
  {
    const SqliteTimeLimit limit(database, 1ms);
    CHECK(code_of(database, endless) == SQLITE_INTERRUPT);
  }
  CHECK(database.integer("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<100000) "
                         "SELECT count(*) FROM n") == 100'000);
}
