// Fuzz target: any bytes in the records that the daemon leaves for its next start, chosen by the first byte:
// o plate-occupied, h queue-held, e ended-jobs, c copied originals, r the file being read, l light.json, p
// the names in printing/ and beside it, g the place of the print under way, s its fields with a checksum that
// is right. A valid record reads back the same, an invalid one is ignored, and no file is lost. An '@' in c
// and r is replaced by the mark of an existing job.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/light_config.hpp"
#include "daemon/jobs/print_archivist.hpp"
#include "daemon/progress/progress_record.hpp"
#include "daemon/spool/copied_originals.hpp"
#include "daemon/spool/job_moves.hpp"
#include "daemon/spool/reading_record.hpp"
#include "daemon/spool/state_records.hpp"
#include "daemon/system/checksum.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"
#include "tests/fuzz/told.hpp"

namespace contourd::fuzz {
namespace {

namespace fs = std::filesystem;

// The functions that get and set a record of StateRecords.
using Get = std::optional<std::string> (StateRecords::*)() const;
using Set = void (StateRecords::*)(const std::optional<std::string>&) const;

void check_line(const char* name, Get get, Set set, std::string_view bytes) {
  static const testing::TemporaryFolder left, next;
  (void)left.write(name, bytes);
  const std::optional<std::string> read = (StateRecords(left.path()).*get)();
  demand(read.has_value(), "an existing record is not read");
  demand(*read == bytes.substr(0, bytes.find('\n')), "a record is more than its first line");
  (StateRecords(next.path()).*set)(read);
  demand((StateRecords(next.path()).*get)() == read, "a record does not read back");
  (StateRecords(next.path()).*set)(std::nullopt);
  demand(!(StateRecords(next.path()).*get)(), "a removed record still exists");
}

// Returns the fields of a record, with a mark in place of each '@'.
std::vector<std::string> ends_in(const JobEndRecord& record) {
  std::vector<std::string> ends;
  for (const JobEndRecord::Pending& each : record.pending()) {
    std::string end = std::to_string(each.end.key) + " " + each.end.job + " " + each.end.reason;
    for (const EndConsumer consumer : each.consumers)
      end += std::to_string(static_cast<int>(consumer));
    ends.push_back(end);
  }
  return ends;
}

void check_ends(std::string_view bytes) {
  static const testing::TemporaryFolder folder;
  (void)folder.write("ended-jobs", bytes);
  const StateRecords records(folder.path());
  JobEndRecord record(records);
  demand(record.pending().size() <= JobEndRecord::kMost, "the record has no limit");
  for (const JobEndRecord::Pending& each : record.pending())
    demand(each.end.key != 0 && each.end.job.find('/') == std::string::npos, "an invalid end is read");
  record.add({.key = new_job_key(), .job = "new", .outcome = "done"});
  demand(record.end_of("new").has_value(), "a new end is not found");
  demand(ends_in(JobEndRecord(records)) == ends_in(record), "the ends do not read back");
  record.release_name("new");
  demand(!JobEndRecord(records).end_of("new"), "the end of one print is taken for another's");
}

std::string with_mark(std::string_view bytes, const JobFiles& job) {
  std::string text;
  for (const char byte : bytes)
    text += byte == '@' ? mark_of(job) : std::string(1, byte);
  return text;
}

void check_copied(const testing::SpoolFixture& spool, std::string_view bytes) {
  const JobFiles job = spool.folders.files_of(SpoolFolder::Incoming, "part.stl");
  const std::string mark = mark_of(job);
  const fs::path record = spool.folder.write("copied", with_mark(bytes, job));
  CopiedOriginals copied(record);
  copied.settle(spool.folders.path(SpoolFolder::Printing));
  const bool had = copied.contains(job);
  demand(CopiedOriginals(record).contains(job) == had, "what was copied does not read back");
  copied.keep_those_in(spool.folders.path(SpoolFolder::Incoming));
  demand(copied.contains(job) == had, "an existing original is forgotten");
  copied.add(mark);
  demand(CopiedOriginals(record).contains(job), "a copied original is taken again");
  copied.remove(mark);
  demand(!CopiedOriginals(record).contains(job), "a removed mark still blocks its original");
}

void check_reading(const testing::SpoolFixture& spool, std::string_view bytes) {
  const JobFiles job = spool.folders.files_of(SpoolFolder::Incoming, "part.stl");
  std::string boot;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
  const fs::path file = spool.folder.write("reading", boot + "\n" + with_mark(bytes, job));
  ReadingRecord record(file);
  (void)record.take_ended(job);
  demand(!record.take_ended(job), "an end is reported twice");
  demand(!ReadingRecord(file).take_ended(job), "an end is reported again after a restart");
}

void check_light(const testing::TemporaryFolder& folder, const std::string& text) {
  try {
    const LightConfig light = read_light_record(folder.write("light.json", text));
    const LightConfig dark = read_light_record(folder.write("light.json", left_dark(text)));
    demand(dark.left_dark, "darkness does not read back");
    demand(dark.line.has_value() == light.line.has_value(), "the light line is lost");
    demand(dark.projector.has_value() == light.projector.has_value(), "the light's projector is lost");
  } catch (const ConfigError& error) {
    demand_told(error);
  }
}

// Returns the two copies of a record with these fields, in which a newline stands for a zero byte. The second
// copy has the fields after a '#'.
std::string sealed(std::string_view fields) {
  constexpr std::string_view kWord = "contourd-progress 1 ";
  constexpr std::size_t kDigits = 16;
  std::string text;
  for (std::size_t copy = 0; copy < 2; ++copy) {
    const std::size_t end = std::min(fields.find('#'), fields.size());
    std::string body(fields.substr(0, end));
    fields.remove_prefix(std::min(end + 1, fields.size()));
    std::ranges::replace(body, '\n', '\0');
    body.resize(ProgressRecord::kCopyBytes - kWord.size() - kDigits, '\0');
    text.resize(copy * ProgressRecord::kCopyDistance, '\0');
    text += fmt::format("{}{:016x}", kWord, checksum_of(body)) + body;
  }
  return text;
}

void check_progress(const testing::TemporaryFolder& folder, const std::string& text) {
  const fs::path file = folder.write("place", text);
  ProgressRecord record(file);
  const ProgressRecord::Found found = record.read();
  if (!found.progress) {
    demand(!found.trouble.empty() || std::ranges::all_of(text, [](char byte) { return byte == '\0'; }),
           "a record that cannot be used is not told");
    return;
  }
  const PrintProgress& print = found.progress->print;
  demand(found.progress->layers > 0 && print.layer >= 0 && print.thickness > Nanometers{},
         "a print without a layer is read");
  demand(!print.plate || print.plate->least <= print.plate->most, "a plate's heights are read in reverse");
  demand(found.progress->changes.excluded.size() <= ProgressRecord::kMostExcluded, "the record has no limit");
  // The names that a file system allows, and marks, are shorter.
  constexpr std::size_t kLongestName = 255, kLongestMark = 500;
  if (found.progress->job.size() > kLongestName || found.progress->marks.files.size() > kLongestMark) return;
  for (int write = 0; write < 2; ++write) {
    record.go_on();
    record.write(*found.progress);
    demand(record.read().progress == found.progress, "the latest progress does not read back");
  }
  demand(record.read().trouble.empty(), "two copies that were just written are in trouble");
  record.end();
  demand(!ProgressRecord(file).read().progress, "the progress of an ended print is read");
}

std::string folder_called(char letter) {
  switch (letter) {
    case 'i':
      return "incoming/";
    case 'd':
      return "done/";
    case 'f':
      return "failed/";
    default:
      return "printing/";
  }
}

bool is_file_name(std::string_view name) {
  constexpr std::string_view separators("/\0", 2);
  return !name.empty() && name.size() <= 200 && name.find_first_of(separators) == std::string_view::npos &&
         name != "." && name != "..";
}

// Creates a file for each line: a folder's letter and the file's name there; P for a plate in printing/.
void put_files(const testing::SpoolFixture& spool, std::string_view lines) {
  for (std::size_t files = 0; !lines.empty() && files < 20; ++files) {
    const std::string_view line = lines.substr(0, lines.find('\n'));
    lines.remove_prefix(std::min(line.size() + 1, lines.size()));
    if (line.empty() || !is_file_name(line.substr(1))) continue;
    const std::string path = folder_called(line[0]) + std::string(line.substr(1));
    if (!spool.has(path)) spool.put(path + (line[0] == 'P' ? "/plate.json" : ""), line);
  }
}

std::vector<std::string> files_in(const testing::SpoolFixture& spool) {
  std::vector<std::string> texts;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(spool.folder.path()))
    if (entry.is_regular_file())
      texts.push_back(spool.text_of(fs::relative(entry.path(), spool.folder.path())));
  std::ranges::sort(texts);
  return texts;
}

void check_printing(std::string_view names) {
  const testing::SpoolFixture spool;
  put_files(spool, names);
  const std::vector<std::string> files = files_in(spool);
  const std::vector<JobFiles> jobs = jobs_left_in_printing(spool.folders);
  demand(files_in(spool) == files, "a file is lost");
  for (const JobFiles& job : jobs)
    demand(fs::exists(job.model) && !job.name.empty(), "a job without a model");
  demand(jobs_left_in_printing(spool.folders).size() == jobs.size(), "the next start finds other jobs");
}

void check(char kind, std::string_view bytes) {
  static const testing::TemporaryFolder folder;
  static const testing::SpoolFixture spool;
  spool.put("incoming/part.stl");
  switch (kind) {
    case 'o':
      return check_line("plate-occupied", &StateRecords::plate_occupant, &StateRecords::set_plate_occupant,
                        bytes);
    case 'h':
      return check_line("queue-held", &StateRecords::hold, &StateRecords::set_hold, bytes);
    case 'e':
      return check_ends(bytes);
    case 'c':
      return check_copied(spool, bytes);
    case 'r':
      return check_reading(spool, bytes);
    case 'l':
      return check_light(folder, std::string(bytes));
    case 'p':
      return check_printing(bytes);
    case 'g':
      return check_progress(folder, std::string(bytes));
    case 's':
      return check_progress(folder, sealed(bytes));
    default:
      return;
  }
}

}  // namespace
}  // namespace contourd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0)
    contourd::fuzz::check(static_cast<char>(data[0]), {reinterpret_cast<const char*>(data) + 1, size - 1});
  return 0;
}
