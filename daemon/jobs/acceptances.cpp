#include "daemon/jobs/acceptances.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <exception>
#include <filesystem>

#include "daemon/spool/copied_originals.hpp"

namespace contourd {

void Acceptances::load(Lines lines) {
  keeper_.load(lines);
  lines_ = std::move(lines);
}

void Acceptances::add(const std::string& content, const std::vector<std::string>& findings) {
  for (const std::string& finding : findings)
    if (!has(content, finding)) lines_.push_back(fmt::format("{} {}", content, finding));
  if (lines_.size() > kMaxLines)
    lines_.erase(lines_.begin(), lines_.end() - static_cast<std::ptrdiff_t>(kMaxLines));
  keeper_.keep(lines_);
}

void Acceptances::remove(const std::string& content) {
  std::erase_if(lines_, [&](const std::string& line) { return line.starts_with(content + " "); });
  keeper_.keep(lines_);
}

void Acceptances::remove(const std::string& content, std::string_view finding) {
  std::erase(lines_, fmt::format("{} {}", content, finding));
  keeper_.keep(lines_);
}

bool Acceptances::has(const std::string& content, const std::string& finding) const {
  return std::ranges::find(lines_, fmt::format("{} {}", content, finding)) != lines_.end();
}

std::string content_mark(const JobFiles& job) {
  std::string text;
  try {
    for (const std::filesystem::path& part : parts_of(job)) {
      struct stat file {};
      if (::stat(part.c_str(), &file) != 0) return "";
      text += fmt::format("{}:{}:{}.{:09};", file.st_ino, file.st_size, file.st_mtim.tv_sec,
                          file.st_mtim.tv_nsec);
    }
  } catch (const std::exception&) {
    return "";
  }
  // Hashed, because a plate may have many files.
  return fmt::format("{:016x}", std::hash<std::string>{}(text));
}

}  // namespace contourd
