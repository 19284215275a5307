// SQLite's database and its statements as values that close themselves (sqlite.org/c3ref). All of it blocks,
// so it is for a worker's thread; one thread at a time.
#pragma once

#include <sqlite3.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace contourd {

class SqliteError : public std::runtime_error {
 public:
  // `code` as SQLite's, such as SQLITE_BUSY or an extended one.
  SqliteError(int code, const std::string& what) : std::runtime_error(what), code_(code) {}

  // Without what an extended code says beyond it.
  [[nodiscard]] int code() const { return code_ & 0xff; }
  // The file is no database, or a damaged one.
  [[nodiscard]] bool is_corruption() const { return code() == SQLITE_CORRUPT || code() == SQLITE_NOTADB; }

 private:
  int code_;
};

class SqliteDatabase {
 public:
  // Opens the file for reading and writing, or makes it. A lock of another program is waited for this long.
  // Throws SqliteError; so does all else here.
  SqliteDatabase(const std::filesystem::path& file, std::chrono::milliseconds patience);
  ~SqliteDatabase();
  SqliteDatabase(const SqliteDatabase&) = delete;
  SqliteDatabase& operator=(const SqliteDatabase&) = delete;

  // One or more statements without results that are wanted.
  void execute(const std::string& sql);
  // The first column of the first row; 0 or empty where there is none.
  [[nodiscard]] std::int64_t integer(const std::string& sql);
  [[nodiscard]] std::string text(const std::string& sql);
  // Rows that the last statement inserted, changed or deleted.
  [[nodiscard]] std::int64_t changes() const;

 private:
  friend class SqliteStatement;
  friend class SqliteTransaction;
  friend class SqliteTimeLimit;

  static int is_too_late(void* self);
  [[noreturn]] void fail(int code) const;

  sqlite3* handle_ = nullptr;
  std::chrono::steady_clock::time_point deadline_ = std::chrono::steady_clock::time_point::max();
};

class SqliteStatement {
 public:
  // The database must outlive the statement.
  SqliteStatement(SqliteDatabase& database, std::string_view sql);
  ~SqliteStatement();
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;

  // Values for the question marks, in their order. Texts are copied.
  template <typename... Values>
  SqliteStatement& bind(const Values&... values) {
    int place = 0;
    (bind_at(++place, values), ...);
    return *this;
  }
  // The next row; false behind the last.
  bool step();

  // Of the row, by column from 0; what is NULL is 0 or empty.
  [[nodiscard]] std::int64_t integer(int column) const { return sqlite3_column_int64(handle_, column); }
  [[nodiscard]] double real(int column) const { return sqlite3_column_double(handle_, column); }
  [[nodiscard]] std::string text(int column) const;

 private:
  void bind_at(int place, std::int64_t value);
  void bind_at(int place, double value);
  void bind_at(int place, std::string_view value);
  void require(int code) const;

  SqliteDatabase& database_;
  sqlite3_stmt* handle_ = nullptr;
};

// What happens between its beginning and commit() is in the database as a whole, or not at all.
class SqliteTransaction {
 public:
  explicit SqliteTransaction(SqliteDatabase& database);
  ~SqliteTransaction();
  SqliteTransaction(const SqliteTransaction&) = delete;
  SqliteTransaction& operator=(const SqliteTransaction&) = delete;

  void commit();

 private:
  SqliteDatabase& database_;
  bool open_ = true;
};

// For as long as it lives, statements that go on beyond this time end with SQLITE_INTERRUPT.
class SqliteTimeLimit {
 public:
  SqliteTimeLimit(SqliteDatabase& database, std::chrono::milliseconds time) : database_(database) {
    database_.deadline_ = std::chrono::steady_clock::now() + time;
  }
  ~SqliteTimeLimit() { database_.deadline_ = std::chrono::steady_clock::time_point::max(); }
  SqliteTimeLimit(const SqliteTimeLimit&) = delete;
  SqliteTimeLimit& operator=(const SqliteTimeLimit&) = delete;

 private:
  SqliteDatabase& database_;
};

}  // namespace contourd
