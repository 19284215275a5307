// The durable record of the print under way, from which the next process learns in which layer and phase a
// power cut ended the print. Not thread-safe: used by one thread after the other. Functions block until the
// disk has the record.
//
// The file has two copies, each with a number and a checksum, which are written alternately and in place: a
// copy that a power cut tears leaves the other. begin() allocates all blocks, so that a later write changes
// no other block of the file system, and cannot fail for lack of room. The copies are 64 KiB apart, more than
// a page of usual flash memory.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/print/print_progress.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

// Marks by which a change of what a job is printed from is noticed. A value.
struct JobMarks {
  std::string files{};         // mark of model and ticket; empty if they cannot be read
  std::uint64_t settings = 0;  // mark of the resin's profile and the display

  bool operator==(const JobMarks&) const = default;
};

// The progress of a job's print. A value.
struct JobProgress {
  std::string job;          // name in printing/
  std::int32_t layers = 0;  // expected
  JobMarks marks{};         // as they were when the print began
  Duration lit{};           // upper bound of the light in all layers before this one
  std::chrono::system_clock::time_point written{};
  PrintProgress print{};
  // The changes made while it printed, from the next layer on.
  struct Changes {
    std::vector<double> settings{};         // the values of kPrintSettings; empty if none was changed
    std::vector<std::uint32_t> excluded{};  // numbers of the copies that are left dark
    bool complete = true;                   // false: more copies than the record holds are left dark

    bool operator==(const Changes&) const = default;
  };
  Changes changes{};

  bool operator==(const JobProgress&) const = default;
};

class ProgressRecord {
 public:
  static constexpr std::size_t kCopyBytes = 4'096, kCopyDistance = 65'536;
  // The most excluded copies that a record holds.
  static constexpr std::size_t kMostExcluded = 256;

  explicit ProgressRecord(std::filesystem::path file) : path_(std::move(file)) {}

  struct Found {
    std::optional<JobProgress> progress;
    std::string trouble{};  // why there is no progress, or why it is not the latest one; empty if all is well
  };
  // Returns the latest progress. Without a file there is neither progress nor trouble.
  [[nodiscard]] Found read() const;

  // Makes a new file with this progress. Throws std::system_error.
  void begin(const JobProgress& progress);
  // Goes on with the file of the process before. Throws std::system_error.
  void go_on();
  // Writes over the older copy. Throws std::system_error, also if begin() or go_on() did.
  void write(const JobProgress& progress);
  // Removes the file: the print is over.
  void end();

 private:
  void open();

  std::filesystem::path path_;
  FileDescriptor file_;
  std::uint64_t number_ = 0;  // the latest copy's
};

}  // namespace contourd
