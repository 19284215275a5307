// Saves the latest lines of a record on the disk, one write at a time, without blocking. Event loop's thread
// only.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace contourd {

class RecordKeeper {
 public:
  using Lines = std::vector<std::string>;
  // Writes these lines to the disk, and calls `done` from the loop with the error; empty on success.
  using Keep = std::function<void(const Lines& lines, std::function<void(const std::string& trouble)> done)>;
  // `failed` is called with the error if a write fails, once for the same error.
  RecordKeeper(Keep keep, std::function<void(const std::string& trouble)> failed)
      : keep_(std::move(keep)), failed_(std::move(failed)) {}

  // Sets the lines that the last process saved.
  void load(Lines lines) { wanted_ = kept_ = std::move(lines); }
  // Saves these lines, after a write that is under way.
  void keep(const Lines& lines);

 private:
  void keep_now();

  Keep keep_;
  std::function<void(const std::string&)> failed_;
  Lines wanted_, kept_;
  bool keeping_ = false;
  std::string trouble_;  // already reported
};

}  // namespace contourd
