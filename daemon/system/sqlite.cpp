#include "daemon/system/sqlite.hpp"

namespace contourd {
namespace {

// The number of SQLite's instructions between two checks of the time limit; they take less than a
// millisecond.
constexpr int kInstructionsBetweenChecks = 10'000;

}  // namespace

SqliteDatabase::SqliteDatabase(const std::filesystem::path& file, std::chrono::milliseconds lock_timeout) {
  const int code = sqlite3_open_v2(file.c_str(), &handle_,
                                   SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
  if (code != SQLITE_OK) {
    const SqliteError error(code, handle_ != nullptr ? sqlite3_errmsg(handle_) : sqlite3_errstr(code));
    sqlite3_close_v2(handle_);
    throw error;
  }
  sqlite3_extended_result_codes(handle_, 1);
  sqlite3_busy_timeout(handle_, static_cast<int>(lock_timeout.count()));
  sqlite3_progress_handler(handle_, kInstructionsBetweenChecks, is_past_deadline, this);
}

SqliteDatabase::~SqliteDatabase() {
  sqlite3_close_v2(handle_);
}

int SqliteDatabase::is_past_deadline(void* self) {
  return std::chrono::steady_clock::now() > static_cast<SqliteDatabase*>(self)->deadline_ ? 1 : 0;
}

void SqliteDatabase::fail(int code) const {
  throw SqliteError(code, sqlite3_errmsg(handle_));
}

void SqliteDatabase::execute(const std::string& sql) {
  if (const int code = sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr); code != SQLITE_OK)
    fail(code);
}

std::int64_t SqliteDatabase::integer(const std::string& sql) {
  SqliteStatement statement(*this, sql);
  return statement.step() ? statement.integer(0) : 0;
}

std::string SqliteDatabase::text(const std::string& sql) {
  SqliteStatement statement(*this, sql);
  return statement.step() ? statement.text(0) : "";
}

std::int64_t SqliteDatabase::changes() const {
  return sqlite3_changes64(handle_);
}

SqliteStatement::SqliteStatement(SqliteDatabase& database, std::string_view sql) : database_(database) {
  require(sqlite3_prepare_v2(database.handle_, sql.data(), static_cast<int>(sql.size()), &handle_, nullptr));
}

SqliteStatement::~SqliteStatement() {
  sqlite3_finalize(handle_);
}

bool SqliteStatement::step() {
  const int code = sqlite3_step(handle_);
  if (code != SQLITE_ROW && code != SQLITE_DONE) database_.fail(code);
  return code == SQLITE_ROW;
}

std::string SqliteStatement::text(int column) const {
  const auto* const bytes = reinterpret_cast<const char*>(sqlite3_column_text(handle_, column));
  if (bytes == nullptr) return "";
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
}

void SqliteStatement::bind_at(int place, std::int64_t value) {
  require(sqlite3_bind_int64(handle_, place, value));
}
void SqliteStatement::bind_at(int place, double value) {
  require(sqlite3_bind_double(handle_, place, value));
}
void SqliteStatement::bind_at(int place, std::string_view value) {
  require(sqlite3_bind_text64(handle_, place, value.data(), value.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
}

void SqliteStatement::require(int code) const {
  if (code != SQLITE_OK) database_.fail(code);
}

SqliteTransaction::SqliteTransaction(SqliteDatabase& database) : database_(database) {
  database_.execute("BEGIN IMMEDIATE");
}

SqliteTransaction::~SqliteTransaction() {
  if (!open_) return;
  // Fails if SQLite has already rolled back, as after a full disk; that is fine.
  sqlite3_exec(database_.handle_, "ROLLBACK", nullptr, nullptr, nullptr);
}

void SqliteTransaction::commit() {
  database_.execute("COMMIT");
  open_ = false;
}

}  // namespace contourd
