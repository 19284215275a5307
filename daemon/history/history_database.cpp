#include "daemon/history/history_database.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "daemon/system/durable_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using std::chrono::milliseconds;
using std::chrono::system_clock;

// Timeouts for a lock of another program and for a query.
constexpr milliseconds kPatience{500}, kLongestQuery{2000};
// Size limits of a row's texts, and of the number of its warnings.
constexpr std::size_t kLongestText = 1'000, kLongestAnalysis = 8'000, kMostWarnings = 10;
constexpr std::size_t kMostResins = 100;

// `replaced` holds the usage of all prints up to the time when the part was replaced.
constexpr const char* kTables = R"(
CREATE TABLE job(
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  key INTEGER NOT NULL UNIQUE,
  name TEXT NOT NULL,
  outcome TEXT,
  reason TEXT NOT NULL DEFAULT '',
  began_ms INTEGER NOT NULL,
  ended_ms INTEGER NOT NULL DEFAULT 0,
  resin TEXT NOT NULL DEFAULT '',
  settings TEXT NOT NULL DEFAULT '',
  height_mm REAL NOT NULL DEFAULT 0,
  layer_height_um REAL NOT NULL DEFAULT 0,
  layers INTEGER NOT NULL DEFAULT 0,
  layers_exposed INTEGER NOT NULL DEFAULT 0,
  print_time_s REAL NOT NULL DEFAULT 0,
  lit_s REAL NOT NULL DEFAULT 0,
  light_asked_s REAL NOT NULL DEFAULT 0,
  most_light_over_ms REAL NOT NULL DEFAULT 0,
  resin_ml REAL NOT NULL DEFAULT 0,
  interruptions INTEGER NOT NULL DEFAULT 0,
  late_steps INTEGER NOT NULL DEFAULT 0,
  warnings TEXT NOT NULL DEFAULT '[]',
  analysis TEXT NOT NULL DEFAULT 'null'
) STRICT;
CREATE INDEX job_under_way ON job(id) WHERE outcome IS NULL;
CREATE TABLE forgotten(
  resin TEXT PRIMARY KEY,
  jobs INTEGER NOT NULL,
  prints INTEGER NOT NULL,
  layers INTEGER NOT NULL,
  lit_s REAL NOT NULL,
  resin_ml REAL NOT NULL
) STRICT;
CREATE TABLE replaced(
  part TEXT PRIMARY KEY,
  at_ms INTEGER NOT NULL,
  layers INTEGER NOT NULL,
  prints INTEGER NOT NULL,
  lit_s REAL NOT NULL
) STRICT;
)";
// The version of the tables, in user_version; a new file has version 0.
constexpr std::int64_t kVersion = 1;

// The columns in the order of bind_figures().
constexpr const char* kSetFigures =
    "resin=?,settings=?,height_mm=?,layer_height_um=?,layers=?,layers_exposed=?,print_time_s=?,lit_s=?,"
    "light_asked_s=?,most_light_over_ms=?,resin_ml=?,interruptions=?,late_steps=?,warnings=?";
// The usage of the jobs in both tables.
constexpr const char* kUsed =
    "(SELECT resin, 1 AS jobs, layers_exposed>0 AS prints, layers_exposed AS layers, lit_s, resin_ml "
    "FROM job UNION ALL SELECT resin, jobs, prints, layers, lit_s, resin_ml FROM forgotten)";

// Returns the definitions of contourd's tables and indexes; a user may have added others.
std::string schema_of(SqliteDatabase& database) {
  return database.text(
      "SELECT group_concat(name||' '||sql) FROM (SELECT name,sql FROM sqlite_schema WHERE name IN "
      "('job','job_under_way','forgotten','replaced') ORDER BY name)");
}

// Returns the definitions that make_tables() gives a new file.
const std::string& expected_schema() {
  static const std::string schema = [] {
    SqliteDatabase example(":memory:", milliseconds(0));
    example.execute(kTables);
    return schema_of(example);
  }();
  return schema;
}

std::string shortened(std::string_view text) {
  return std::string(text.substr(0, kLongestText));
}

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', true, Json::error_handler_t::replace);
}

std::string warnings_text(const std::vector<std::string>& warnings) {
  Json list = Json::array();
  for (std::size_t i = 0; i < std::min(warnings.size(), kMostWarnings); ++i)
    list.push_back(shortened(warnings[i]));
  if (warnings.size() > kMostWarnings)
    list.push_back(fmt::format("and {} more", warnings.size() - kMostWarnings));
  return text_of(list);
}

std::string analysis_text(const Json& analysis) {
  std::string text = text_of(analysis);
  return text.size() <= kLongestAnalysis ? text : "null";
}

std::int64_t ms(system_clock::time_point time) {
  return std::chrono::duration_cast<milliseconds>(time.time_since_epoch()).count();
}

system_clock::time_point time_at(std::int64_t ms_since_epoch) {
  return system_clock::time_point(milliseconds(ms_since_epoch));
}

template <typename... More>
void bind_figures(SqliteStatement& statement, const JobFigures& figures, const More&... more) {
  statement.bind(shortened(figures.resin), shortened(figures.settings), figures.height_mm,
                 figures.layer_height_um, figures.layers, figures.layers_exposed, figures.print_time_s,
                 figures.lit_s, figures.light_asked_s, figures.most_light_over_ms, figures.resin_ml,
                 figures.interruptions, figures.late_steps, warnings_text(figures.warnings), more...);
}

// Returns the warnings; values that contourd does not write are ignored.
std::vector<std::string> warnings_in(const std::string& text) {
  std::vector<std::string> warnings;
  const Json list = Json::parse(text, nullptr, false);
  if (!list.is_array()) return warnings;
  for (const Json& each : list)
    if (each.is_string()) warnings.push_back(each.get<std::string>());
  return warnings;
}

constexpr const char* kColumns =
    "name,outcome,reason,began_ms,ended_ms,analysis,resin,settings,height_mm,layer_height_um,layers,"
    "layers_exposed,print_time_s,lit_s,light_asked_s,most_light_over_ms,resin_ml,interruptions,late_steps,"
    "warnings,id";
constexpr int kIdColumn = 20;

EndedJob job_in(const SqliteStatement& row) {
  EndedJob job{.name = row.text(0), .outcome = row.text(1), .reason = row.text(2)};
  job.began = time_at(row.integer(3));
  job.ended = time_at(row.integer(4));
  job.analysis = Json::parse(row.text(5), nullptr, false);
  if (!job.analysis.is_object()) job.analysis = Json();
  job.figures = {.resin = row.text(6),
                 .settings = row.text(7),
                 .warnings = warnings_in(row.text(19)),
                 .height_mm = row.real(8),
                 .layer_height_um = row.real(9),
                 .layers = row.integer(10),
                 .layers_exposed = row.integer(11),
                 .print_time_s = row.real(12),
                 .lit_s = row.real(13),
                 .light_asked_s = row.real(14),
                 .most_light_over_ms = row.real(15),
                 .resin_ml = row.real(16),
                 .interruptions = row.integer(17),
                 .late_steps = row.integer(18)};
  return job;
}

Usage usage_in(const SqliteStatement& row) {
  return {row.text(0), row.integer(1), row.integer(2), row.real(3), row.real(4)};
}

// Thrown if a later version of contourd made the file.
class NewerHistory : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Maximum number of damaged files that are kept; a further one replaces the last.
constexpr int kMostAside = 9;

struct FoundFile {
  ino_t inode = 0;
  std::string wrong;  // why the path is not usable, such as "is a folder"; empty for a regular file
};

// Returns nullopt if the path does not exist. Throws std::system_error.
std::optional<FoundFile> look_at(const fs::path& file) {
  struct stat status {};
  if (::lstat(file.c_str(), &status) != 0) {
    if (errno == ENOENT) return std::nullopt;
    throw std::system_error(errno, std::generic_category());
  }
  FoundFile found{.inode = status.st_ino, .wrong = {}};
  if (S_ISDIR(status.st_mode)) found.wrong = "is a folder";
  if (S_ISLNK(status.st_mode)) found.wrong = "is a link, which is not followed";
  if (found.wrong.empty() && !S_ISREG(status.st_mode)) found.wrong = "is not a file";
  return found;
}

fs::path with(const fs::path& file, const std::string& ending) {
  return file.string() + ending;
}

std::string reason(const SqliteError& error) {
  switch (error.code()) {
    case SQLITE_BUSY:
      return "another program has locked it";
    case SQLITE_FULL:
      return "the disk is full";
    case SQLITE_READONLY:
      return "it cannot be written";
    case SQLITE_INTERRUPT:
      return "the query takes too long";
    default:
      return error.what();
  }
}

}  // namespace

// --- the file

void HistoryDatabase::open() {
  const std::optional<FoundFile> found = look_at(file_);
  // A user may have removed or replaced the file.
  if (database_ && found && found->inode == inode_) return;
  database_.reset();
  for (const char* ending : {"", "-wal", "-shm"}) {
    const std::optional<FoundFile> each = look_at(with(file_, ending));
    if (each && !each->wrong.empty())
      throw SqliteError(SQLITE_CANTOPEN,
                        fmt::format("{} {}", with(file_, ending).filename().string(), each->wrong));
  }
  inode_ = 0;  // if check_file() throws, the next call opens the file again
  database_.emplace(file_, kPatience);
  check_file();
  make_tables();
  if (!found) sync_folder(file_.parent_path());
  const std::optional<FoundFile> opened = look_at(file_);
  inode_ = opened ? opened->inode : 0;
}

void HistoryDatabase::use(const std::function<void()>& call) {
  const auto sentence = [this](const std::string& why) {
    return std::runtime_error(fmt::format("the history in {} cannot be used: {}", file_.string(), why));
  };
  for (bool is_retry = false;; is_retry = true) {
    try {
      open();
      return call();
    } catch (const SqliteError& error) {
      // After any error except a lock and a timeout, the file is opened and checked again.
      if (error.code() != SQLITE_BUSY && error.code() != SQLITE_INTERRUPT) database_.reset();
      if (is_retry || !error.is_corruption()) throw sentence(reason(error));
      try {
        put_aside(error.what());
      } catch (const std::system_error& not_renamed) {
        throw sentence(fmt::format("it is damaged ({}), and cannot be renamed: {}", error.what(),
                                   not_renamed.code().message()));
      }
    } catch (const NewerHistory& newer) {
      database_.reset();
      throw sentence(newer.what());
    } catch (const std::system_error& error) {
      database_.reset();
      throw sentence(error.code().message());
    }
  }
}

void HistoryDatabase::put_aside(const std::string& why) {
  int number = 1;
  while (number < kMostAside && look_at(with(file_, fmt::format(".damaged-{}", number))))
    ++number;
  const fs::path aside = with(file_, fmt::format(".damaged-{}", number));
  fs::rename(file_, aside);
  // The write-ahead log belongs to the damaged file and must not be applied to the new one.
  if (look_at(with(file_, "-wal"))) fs::rename(with(file_, "-wal"), with(aside, "-wal"));
  fs::remove(with(file_, "-shm"));
  sync_folder(file_.parent_path());
  notes_.push_back(
      fmt::format("the history was damaged ({}); it is kept as {}, and a new, empty one begins: the use of "
                  "lamp, film and vat is counted from zero",
                  why, aside.string()));
}

void HistoryDatabase::check_file() {
  const std::int64_t version = database_->integer("PRAGMA user_version");
  if (version > kVersion)
    throw NewerHistory(
        fmt::format("its version is {}, and this contourd reads version {}", version, kVersion));
  if (const std::string found = database_->text("PRAGMA quick_check(1)"); found != "ok")
    throw SqliteError(SQLITE_CORRUPT, found);
  // The quick check accepts definitions with other names of tables and columns.
  if (version == kVersion && schema_of(*database_) != expected_schema())
    throw SqliteError(SQLITE_CORRUPT, "its tables do not have the columns that contourd created");
  // The settings make commits survive a power cut, let other programs read without waiting, write only in
  // the file's folder, and use little memory.
  database_->execute(
      "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA wal_autocheckpoint=200; "
      "PRAGMA journal_size_limit=1048576; PRAGMA temp_store=MEMORY; PRAGMA cache_size=-256; "
      "PRAGMA trusted_schema=OFF");
}

void HistoryDatabase::make_tables() {
  SqliteTransaction transaction(*database_);
  const std::int64_t version = database_->integer("PRAGMA user_version");
  if (version < 0) throw SqliteError(SQLITE_CORRUPT, "its version is below 0");
  if (version == kVersion) return;
  database_->execute(kTables);
  database_->execute(fmt::format("PRAGMA user_version={}", kVersion));
  transaction.commit();
}

// --- changes

void HistoryDatabase::begin(std::int64_t key, const std::string& name, system_clock::time_point when) {
  SqliteStatement(*database_, "INSERT OR IGNORE INTO job(key,name,began_ms) VALUES(?,?,?)")
      .bind(key, name, ms(when))
      .step();
}

void HistoryDatabase::note(std::int64_t key, const JobFigures& figures) {
  SqliteStatement statement(
      *database_, fmt::format("UPDATE job SET {} WHERE key=? AND outcome IS NULL AND lit_s<=?", kSetFigures));
  bind_figures(statement, figures, key, figures.lit_s);
  statement.step();
}

void HistoryDatabase::forget(std::int64_t key) {
  SqliteStatement(*database_, "DELETE FROM job WHERE key=? AND outcome IS NULL").bind(key).step();
}

void HistoryDatabase::end(std::int64_t key, const EndedJob& job) {
  SqliteTransaction transaction(*database_);
  begin(key, job.name, job.began);
  SqliteStatement statement(
      *database_,
      fmt::format(
          "UPDATE job SET {},outcome=?,reason=?,ended_ms=?,analysis=? WHERE key=? AND outcome IS NULL",
          kSetFigures));
  bind_figures(statement, job.figures, job.outcome, shortened(job.reason), ms(job.ended),
               analysis_text(job.analysis), key);
  statement.step();
  forget_oldest();
  transaction.commit();
}

// --- jobs that the previous process left without an outcome

void HistoryDatabase::adopt(const std::vector<JobEnd>& ends) {
  SqliteTransaction transaction(*database_);
  for (const JobEnd& end : ends)
    adopt_end(end);
  // A job without light and without a recorded end was given back to the queue.
  database_->execute("DELETE FROM job WHERE outcome IS NULL AND layers_exposed=0 AND lit_s=0");
  SqliteStatement(*database_, "UPDATE job SET outcome='failed',reason=?,ended_ms=? WHERE outcome IS NULL")
      .bind(kEndNotNoted, ms(system_clock::now()))
      .step();
  transaction.commit();
}

void HistoryDatabase::adopt_end(const JobEnd& end) {
  // contourd records the end of an interrupted print at its next start, under a new key. The print's row has
  // the key that it was begun with, so the row gets the new one.
  SqliteStatement(
      *database_,
      "UPDATE OR IGNORE job SET key=? WHERE id=(SELECT max(id) FROM job WHERE outcome IS NULL AND "
      "name=?)")
      .bind(end.key, end.job)
      .step();
  begin(end.key, end.job, end.ended);
  note(end.key, ended_job(end).figures);
  SqliteStatement(*database_, "UPDATE job SET outcome=?,reason=?,ended_ms=? WHERE key=? AND outcome IS NULL")
      .bind(end.outcome, shortened(end.reason), ms(end.ended), end.key)
      .step();
}

void HistoryDatabase::forget_oldest() {
  const std::int64_t jobs = database_->integer("SELECT count(*) FROM job");
  if (jobs <= kMostJobs) return;
  const std::string oldest = fmt::format(
      "id IN (SELECT id FROM job WHERE outcome IS NOT NULL ORDER BY id LIMIT {})", jobs - kMostJobs);
  database_->execute(fmt::format(
      "INSERT INTO forgotten(resin,jobs,prints,layers,lit_s,resin_ml) SELECT resin,count(*),"
      "sum(layers_exposed>0),sum(layers_exposed),sum(lit_s),sum(resin_ml) FROM job "
      "WHERE {0} GROUP BY resin ON CONFLICT(resin) DO UPDATE SET jobs=jobs+excluded.jobs,"
      "prints=prints+excluded.prints,"
      "layers=layers+excluded.layers,lit_s=lit_s+excluded.lit_s,resin_ml=resin_ml+excluded.resin_ml;"
      "DELETE FROM job WHERE {0}",
      oldest));
}

// --- queries

HistoryPage HistoryDatabase::list(const HistoryQuery& query) {
  const SqliteTimeLimit limit(*database_, kLongestQuery);
  // Conditions that are not set hold for every row.
  SqliteStatement rows(
      *database_, fmt::format("SELECT {} FROM job WHERE outcome IS NOT NULL AND id<?1 AND ended_ms>=?2 AND "
                              "(?3='' OR outcome=?3) AND (?4='' OR resin=?4) AND (?5='' OR instr(name,?5)>0) "
                              "ORDER BY id DESC LIMIT ?6",
                              kColumns));
  rows.bind(query.before.value_or(INT64_MAX), query.since ? ms(*query.since) : INT64_MIN,
            query.outcome.value_or(""), query.resin.value_or(""), query.name.value_or(""),
            static_cast<std::int64_t>(query.last + 1));
  HistoryPage page;
  std::vector<Json> found;
  std::size_t bytes = 0;
  std::int64_t earliest = 0;
  while (rows.step()) {
    if (found.size() == query.last || bytes > HistoryPage::kMostBytes) {
      page.before = earliest;
      break;
    }
    found.push_back(history_json(job_in(rows)));
    bytes += text_of(found.back()).size();
    earliest = rows.integer(kIdColumn);
  }
  std::ranges::move(found.rbegin(), found.rend(), std::back_inserter(page.jobs.get_ref<Json::array_t&>()));
  return page;
}

std::vector<Usage> HistoryDatabase::usage_by_resin() {
  const SqliteTimeLimit limit(*database_, kLongestQuery);
  SqliteStatement rows(*database_,
                       fmt::format("SELECT resin,sum(jobs),sum(layers),sum(lit_s),sum(resin_ml) "
                                   "FROM {} WHERE resin<>'' GROUP BY resin ORDER BY 4 DESC LIMIT {}",
                                   kUsed, kMostResins));
  std::vector<Usage> usage;
  while (rows.step())
    usage.push_back(usage_in(rows));
  return usage;
}

Usage HistoryDatabase::usage() {
  const SqliteTimeLimit limit(*database_, kLongestQuery);
  SqliteStatement row(*database_,
                      fmt::format("SELECT '',sum(jobs),sum(layers),sum(lit_s),sum(resin_ml) FROM {}", kUsed));
  row.step();
  return usage_in(row);
}

// --- wear parts

void HistoryDatabase::replace(WearPart part, system_clock::time_point when) {
  const SqliteTimeLimit limit(*database_, kLongestQuery);
  SqliteStatement(
      *database_,
      fmt::format("INSERT OR REPLACE INTO replaced(part,at_ms,layers,prints,lit_s) SELECT "
                  "?1,?2,coalesce(sum(layers),0),coalesce(sum(prints),0),coalesce(sum(lit_s),0) FROM {}",
                  kUsed))
      .bind(name_of(part), ms(when))
      .step();
}

std::vector<WearPartUse> HistoryDatabase::wear() {
  constexpr double kSecondsPerHour = 3600;
  const SqliteTimeLimit limit(*database_, kLongestQuery);
  SqliteStatement all(*database_, fmt::format("SELECT sum(layers),sum(prints),sum(lit_s) FROM {}", kUsed));
  all.step();
  std::vector<WearPartUse> uses;
  for (const WearPart part : kWearParts) {
    WearPartUse use{.part = part};
    SqliteStatement row(*database_, "SELECT layers,prints,lit_s,at_ms FROM replaced WHERE part=?");
    use.layers = all.integer(0);
    use.prints = all.integer(1);
    double lit_s = all.real(2);
    if (row.bind(name_of(part)).step()) {
      use.layers -= row.integer(0);
      use.prints -= row.integer(1);
      lit_s -= row.real(2);
      use.replaced = time_at(row.integer(3));
    }
    use.lamp_h = std::max(lit_s, 0.0) / kSecondsPerHour;
    uses.push_back(use);
  }
  return uses;
}

}  // namespace contourd
