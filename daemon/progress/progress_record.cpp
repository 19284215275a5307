#include "daemon/progress/progress_record.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

#include "daemon/print/print_settings.hpp"
#include "daemon/system/checksum.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {
namespace {

using std::chrono::milliseconds;
using std::chrono::system_clock;

// A copy is a text: this word, the version, the checksum of all that follows, and the fields, each followed
// by a zero byte.
constexpr std::string_view kMagic = "contourd-progress ";
constexpr std::string_view kVersion = "1 ";
constexpr std::size_t kChecksumDigits = 16;
// Bounds beyond which no print goes, so that no arithmetic overflows.
constexpr std::int32_t kMostLayers = 10'000'000;
constexpr std::int64_t kMostNm = 10'000'000'000, kMostNs = std::int64_t{1} << 55;
// The latest time that the clock can represent.
constexpr std::int64_t kLatestMs =
    std::chrono::duration_cast<milliseconds>(system_clock::duration::max()).count();
// The largest number of a copy, far beyond the phases of all prints. A damaged record may hold it.
constexpr std::uint64_t kMostNumber = std::uint64_t{1} << 62;
constexpr std::size_t kHeader = kMagic.size() + kVersion.size() + kChecksumDigits;

// Returns the text of a copy, padded with zero bytes.
std::string copy_of(const JobProgress& progress, std::uint64_t number) {
  const PrintProgress& print = progress.print;
  std::string fields;
  const auto add = [&fields](auto value) { fields.append(std::to_string(value)).push_back('\0'); };
  add(number);
  fields.append(progress.job).push_back('\0');
  add(progress.layers);
  fields.append(progress.marks.files).push_back('\0');
  add(progress.marks.settings);
  add(progress.lit.count());
  add(std::chrono::duration_cast<milliseconds>(progress.written.time_since_epoch()).count());
  add(static_cast<int>(print.phase));
  add(print.layer);
  add(print.bottom.count());
  add(print.thickness.count());
  add(print.exposure.count());
  add(print.light.count());
  add(static_cast<int>(print.exposed));
  add(static_cast<int>(print.plate.has_value()));
  add(print.plate ? print.plate->least.count() : 0);
  add(print.plate ? print.plate->most.count() : 0);
  const JobProgress::Changes& changes = progress.changes;
  const bool complete = changes.complete && changes.excluded.size() <= ProgressRecord::kMostExcluded;
  add(static_cast<int>(complete));
  add(changes.settings.size());
  for (const double value : changes.settings)
    fields.append(fmt::format("{}", value)).push_back('\0');
  const std::size_t excluded = std::min(changes.excluded.size(), ProgressRecord::kMostExcluded);
  add(excluded);
  for (std::size_t i = 0; i < excluded; ++i)
    add(changes.excluded[i]);
  fields.resize(ProgressRecord::kCopyBytes - kHeader, '\0');
  return fmt::format("{}{}{:016x}", kMagic, kVersion, checksum_of(fields)) + fields;
}

// Reads the fields of a copy one after the other.
class Fields {
 public:
  explicit Fields(std::string_view text) : text_(text) {}

  std::string text() {
    const std::size_t end = std::min(text_.find('\0'), text_.size());
    std::string field(text_.substr(0, end));
    text_.remove_prefix(std::min(end + 1, text_.size()));
    return field;
  }
  template <typename Number>
  Number number(Number least = std::numeric_limits<Number>::min(),
                Number most = std::numeric_limits<Number>::max()) {
    const std::string field = text();
    Number value{};
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    const bool is_valid = error == std::errc{} && end == field.data() + field.size();
    good_ = good_ && is_valid && value >= least && value <= most;
    return is_valid ? std::clamp(value, least, most) : least;
  }
  [[nodiscard]] bool good() const { return good_; }

 private:
  std::string_view text_;
  bool good_ = true;
};

struct Copy {
  enum class State { Empty, Valid, OtherVersion, Damaged } state = State::Empty;
  std::uint64_t number = 0;
  JobProgress progress{};
};

PrintProgress print_in(Fields& fields) {
  PrintProgress print;
  print.phase = PrintPhase{fields.number<std::uint8_t>(0, kNames<PrintPhase>.size() - 1)};
  print.layer = fields.number<std::int32_t>(0, kMostLayers);
  print.bottom = Nanometers{fields.number<std::int64_t>(0, kMostNm)};
  print.thickness = Nanometers{fields.number<std::int64_t>(1, kMostNm)};
  print.exposure = Duration{fields.number<std::int64_t>(0, kMostNs)};
  print.light = Duration{fields.number<std::int64_t>(0, kMostNs)};
  print.exposed = fields.number<int>(0, 1) != 0;
  const bool known = fields.number<int>(0, 1) != 0;
  const Nanometers least{fields.number<std::int64_t>(-kMostNm, kMostNm)};
  const Nanometers most{fields.number<std::int64_t>(least.count(), kMostNm)};
  if (known) print.plate = {least, most};
  return print;
}

JobProgress::Changes changes_in(Fields& fields) {
  constexpr double kMostValue = 1e9;
  JobProgress::Changes changes;
  changes.complete = fields.number<int>(0, 1) != 0;
  changes.settings.resize(fields.number<std::size_t>(0, kPrintSettings.size()));
  for (double& value : changes.settings)
    value = fields.number<double>(0, kMostValue);
  changes.excluded.resize(fields.number<std::size_t>(0, ProgressRecord::kMostExcluded));
  for (std::uint32_t& number : changes.excluded)
    number = fields.number<std::uint32_t>();
  return changes;
}

Copy parse(std::string_view text) {
  if (std::ranges::all_of(text, [](char byte) { return byte == '\0'; })) return {};
  if (!text.starts_with(kMagic) || text.size() != ProgressRecord::kCopyBytes) return {Copy::State::Damaged};
  if (!text.substr(kMagic.size()).starts_with(kVersion)) return {Copy::State::OtherVersion};
  const std::string_view body = text.substr(kHeader);
  if (text.substr(kMagic.size() + kVersion.size(), kChecksumDigits) !=
      fmt::format("{:016x}", checksum_of(body)))
    return {Copy::State::Damaged};
  Fields fields(body);
  Copy copy{Copy::State::Valid};
  copy.number = fields.number<std::uint64_t>(1, kMostNumber);
  JobProgress& progress = copy.progress;
  progress.job = fields.text();
  progress.layers = fields.number<std::int32_t>(1, kMostLayers);
  progress.marks.files = fields.text();
  progress.marks.settings = fields.number<std::uint64_t>();
  progress.lit = Duration{fields.number<std::int64_t>(0, kMostNs)};
  progress.written = system_clock::time_point(milliseconds{fields.number<std::int64_t>(0, kLatestMs)});
  progress.print = print_in(fields);
  progress.changes = changes_in(fields);
  return fields.good() ? copy : Copy{Copy::State::Damaged};
}

std::array<Copy, 2> copies_in(const std::string& text) {
  std::array<Copy, 2> copies;
  for (std::size_t i = 0; i < copies.size(); ++i) {
    const std::size_t at = std::min(i * ProgressRecord::kCopyDistance, text.size());
    copies[i] = parse(std::string_view(text).substr(at, ProgressRecord::kCopyBytes));
  }
  return copies;
}

// Returns the record's text; empty if there is no record. Throws std::system_error.
std::string text_in(const std::filesystem::path& path) {
  std::string text(ProgressRecord::kCopyDistance + ProgressRecord::kCopyBytes, '\0');
  try {
    const FileDescriptor file = open_regular_file(path, Links::Refuse);
    const ssize_t got = ::pread(file.get(), text.data(), text.size(), 0);
    if (got < 0) throw std::system_error(errno, std::generic_category(), "it cannot be read");
    text.resize(static_cast<std::size_t>(got));
  } catch (const UnreadableFile& unreadable) {
    if (unreadable.code() != std::errc::no_such_file_or_directory) throw;
    text.clear();
  }
  return text;
}

// Returns the record's copies, and why it cannot be read; empty if it can.
std::pair<std::array<Copy, 2>, std::string> copies_at(const std::filesystem::path& path) {
  try {
    return {copies_in(text_in(path)), ""};
  } catch (const std::system_error& error) {
    return {{}, fmt::format("{} cannot be used: {}", path.string(), error.what())};
  }
}

}  // namespace

ProgressRecord::Found ProgressRecord::read() const {
  auto [copies, trouble] = copies_at(path_);
  const auto any = [&copies = copies](Copy::State state) {
    return std::ranges::find(copies, state, &Copy::state) != copies.end();
  };
  const bool any_valid = any(Copy::State::Valid);
  if (any(Copy::State::OtherVersion) && !any_valid)
    trouble = fmt::format("{} is of another version of contourd", path_.string());
  else if (any(Copy::State::Damaged) || any(Copy::State::OtherVersion))
    trouble = fmt::format("{} is damaged", path_.string());
  if (!any_valid) return {std::nullopt, trouble};
  return {std::ranges::max(copies, {}, &Copy::number).progress, trouble};
}

void ProgressRecord::open() {
  file_ = FileDescriptor(::open(path_.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!file_.valid())
    throw std::system_error(errno, std::generic_category(), "cannot open " + path_.string());
}

void ProgressRecord::begin(const JobProgress& progress) {
  number_ = 1;
  std::string text = copy_of(progress, number_);
  text.resize(kCopyDistance + kCopyBytes, '\0');
  write_durably(path_, text);
  open();
}

void ProgressRecord::go_on() {
  for (const Copy& copy : copies_in(text_in(path_)))
    number_ = std::max(number_, copy.number);
  const std::optional<JobProgress> progress = number_ < kMostNumber ? std::nullopt : read().progress;
  progress ? begin(*progress) : open();
}

void ProgressRecord::write(const JobProgress& progress) {
  const std::string text = copy_of(progress, ++number_);
  // begin() writes number 1 as the first copy.
  const auto at = static_cast<off_t>((number_ + 1) % 2 * kCopyDistance);
  const ssize_t written = ::pwrite(file_.get(), text.data(), text.size(), at);
  if (written != static_cast<ssize_t>(text.size()) || ::fdatasync(file_.get()) != 0)
    throw std::system_error(written < 0 || written == static_cast<ssize_t>(text.size()) ? errno : EIO,
                            std::generic_category(), "cannot write " + path_.string());
}

void ProgressRecord::end() {
  file_ = FileDescriptor();
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace contourd
