// Has the latest lines of a record on the disk, one write at a time, without waiting for it. Event loop's
// thread only.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace contourd {

class RecordKeeper {
 public:
  using Lines = std::vector<std::string>;
  // Has these lines on the disk, and calls `done` from the loop with why it could not; empty when it could.
  using Keep = std::function<void(const Lines& lines, std::function<void(const std::string& trouble)> done)>;
  // `failed` is told why the disk does not have the lines, once for the same reason.
  RecordKeeper(Keep keep, std::function<void(const std::string& trouble)> failed)
      : keep_(std::move(keep)), failed_(std::move(failed)) {}

  // What the last process has kept.
  void load(Lines lines) { wanted_ = kept_ = std::move(lines); }
  void keep(const Lines& lines);

 private:
  void keep_now();

  Keep keep_;
  std::function<void(const std::string&)> failed_;
  Lines wanted_, kept_;
  bool keeping_ = false;
  std::string trouble_;  // told already
};

}  // namespace contourd
