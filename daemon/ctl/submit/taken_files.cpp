#include "daemon/ctl/submit/taken_files.hpp"

#include <algorithm>
#include <fstream>

#include "core/contract/expects.hpp"
#include "daemon/system/durable_file.hpp"

namespace contourd::ctl {

TakenFiles::TakenFiles(const std::filesystem::path& path) : path_(std::filesystem::absolute(path)) {
  std::ifstream file(path_);
  for (std::string line; marks_.size() < kMost && std::getline(file, line);)
    marks_.push_back(line);
}

bool TakenFiles::contains(const std::string& mark) const {
  return std::ranges::find(marks_, mark) != marks_.end();
}

void TakenFiles::add(const std::string& mark) {
  expects(mark.find('\n') == std::string::npos, "a mark is one line");
  marks_.push_back(mark);
  if (marks_.size() > kMost) marks_.pop_front();
  std::string text;
  for (const std::string& each : marks_)
    text += each + '\n';
  write_durably(path_, text);
}

}  // namespace contourd::ctl
