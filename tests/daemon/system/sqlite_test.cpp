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

TEST_CASE("Values bound to an SQLite statement come back unchanged, also texts of any bytes") {
  DatabaseFixture fixture;
  const std::string name = "'; DROP TABLE thing; -- \xff\x01";
  SqliteStatement(fixture.database, "INSERT INTO thing VALUES(?,?,?)")
      .bind(std::int64_t{-7'000'000'000}, 0.25, name)
      .step();
  CHECK(fixture.database.changes() == 1);
  SqliteStatement row(fixture.database, "SELECT number,size,name,NULL FROM thing");
  REQUIRE(row.step());
  CHECK(row.integer(0) == -7'000'000'000);
  CHECK(row.real(1) == 0.25);
  CHECK(row.text(2) == name);
  CHECK(row.text(3).empty());
  CHECK_FALSE(row.step());
  CHECK(fixture.database.text("SELECT name FROM thing WHERE number=0").empty());
}

TEST_CASE("An SQLite transaction that is not committed changes nothing") {
  DatabaseFixture fixture;
  {
    SqliteTransaction transaction(fixture.database);
    fixture.database.execute("INSERT INTO thing VALUES(1,1,'')");
  }
  CHECK(fixture.count() == 0);
  SqliteTransaction transaction(fixture.database);
  fixture.database.execute("INSERT INTO thing VALUES(1,1,'')");
  transaction.commit();
  CHECK(fixture.count() == 1);
}

TEST_CASE("SQLite's errors keep their code: invalid SQL, a lock, a missing folder") {
  DatabaseFixture fixture;
  CHECK(code_of(fixture.database, "SELEKT 1") == SQLITE_ERROR);
  CHECK_THROWS_AS(SqliteStatement(fixture.database, "SELECT nothing FROM thing"), SqliteError);
  SqliteDatabase other(fixture.file, 0ms);
  const SqliteTransaction transaction(other);
  CHECK(code_of(fixture.database, "BEGIN IMMEDIATE") == SQLITE_BUSY);
  try {
    const SqliteDatabase nowhere(fixture.file / "things.sqlite", 0ms);
    FAIL("opened");
  } catch (const SqliteError& error) {
    CHECK(error.code() == SQLITE_CANTOPEN);
    CHECK_FALSE(error.is_corruption());
  }
}

TEST_CASE("An endless SQLite statement is interrupted at its time limit, and the next one runs") {
  DatabaseFixture fixture;
  const std::string endless =
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n) SELECT count(*) FROM n";
  {
    const SqliteTimeLimit limit(fixture.database, 1ms);
    CHECK(code_of(fixture.database, endless) == SQLITE_INTERRUPT);
  }
  CHECK(
      fixture.database.integer("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<100000) "
                               "SELECT count(*) FROM n") == 100'000);
}
