// RAII types for SQLite's databases and statements (sqlite.org/c3ref). All functions block, so use them on a
// worker's thread, from one thread at a time.
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
  // `code` is a result code of SQLite, possibly an extended one.
  SqliteError(int code, const std::string& what) : std::runtime_error(what), code_(code) {}

  // Returns the primary result code, such as SQLITE_BUSY.
  [[nodiscard]] int code() const { return code_ & 0xff; }
  // True if the file is not a database or is damaged.
  [[nodiscard]] bool is_corruption() const { return code() == SQLITE_CORRUPT || code() == SQLITE_NOTADB; }

 private:
  int code_;
};

class SqliteDatabase {
 public:
  // Opens the file for reading and writing, or creates it. Each access waits up to `lock_timeout` for another
  // program's lock. All functions throw SqliteError.
  SqliteDatabase(const std::filesystem::path& file, std::chrono::milliseconds lock_timeout);
  ~SqliteDatabase();
  SqliteDatabase(const SqliteDatabase&) = delete;
  SqliteDatabase& operator=(const SqliteDatabase&) = delete;

  // Executes one or more statements and discards their results.
  void execute(const std::string& sql);
  // Returns the first column of the first row; 0 or empty if there is no row.
  [[nodiscard]] std::int64_t integer(const std::string& sql);
  [[nodiscard]] std::string text(const std::string& sql);
  // Rows that the last statement inserted, changed or deleted.
  [[nodiscard]] std::int64_t changes() const;

 private:
  friend class SqliteStatement;
  friend class SqliteTransaction;
  friend class SqliteTimeLimit;

  static int is_past_deadline(void* self);
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

  // Binds values to the question marks, in order. Texts are copied.
  template <typename... Values>
  SqliteStatement& bind(const Values&... values) {
    int place = 0;
    (bind_at(++place, values), ...);
    return *this;
  }
  // Advances to the next row. Returns false after the last one.
  bool step();

  // Return a column of the current row, counted from 0; NULL becomes 0 or empty.
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

// A transaction: the changes between its construction and commit() are applied completely or, without
// commit(), not at all.
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

// A time limit for as long as this object lives: statements that exceed it fail with SQLITE_INTERRUPT.
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
