#include "daemon/control/metrics_file.hpp"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "daemon/system/new_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// It gives way to all else.
constexpr int kMetricsNiceness = 19;

// Returns why not, or nothing. Its readers see the old file or the new one.
std::string replace(const fs::path& path, const std::string& text) {
  try {
    remove_unfinished_files(path.parent_path());
    NewFile file(path.parent_path());
    file.let_all_read();
    file.write(text);
    file.replace_for_now(path.filename().string());
  } catch (const std::system_error& error) {
    return error.code().message();
  }
  return "";
}

}  // namespace

MetricsFile::MetricsFile(EventLoop& loop, const Log& log, fs::path path, std::function<std::string()> make,
                         Duration interval)
    : loop_(loop),
      log_(log),
      path_(std::move(path)),
      make_(std::move(make)),
      interval_(interval),
      there_(std::make_shared<bool>(false)),
      worker_(loop, "contourd-metric", kMetricsNiceness) {
  timer_ = loop_.at(std::chrono::steady_clock::now(), "the metrics' timer", [this] { look(); });
}

MetricsFile::~MetricsFile() {
  worker_.run(
      [path = path_, there = there_] {
        std::error_code error;
        return *there && fs::remove(path, error);
      },
      [](bool) {});
}

void MetricsFile::look() {
  timer_ = loop_.at(std::chrono::steady_clock::now() + interval_, "the metrics' timer", [this] { look(); });
  if (writing_) return;  // a slow disk: the next time
  const std::string text = make_();
  if (text != written_) write(text);
}

void MetricsFile::write(const std::string& text) {
  writing_ = true;
  worker_.run(
      [path = path_, there = there_, text] {
        std::string trouble = replace(path, text);
        *there = *there || trouble.empty();
        return trouble;
      },
      [this, text](const std::string& trouble) {
        writing_ = false;
        if (trouble.empty()) written_ = text;
        note(trouble);
      });
}

void MetricsFile::note(const std::string& trouble) {
  if (std::exchange(trouble_, trouble) == trouble) return;
  const std::string path = printable(path_.string());
  if (trouble.empty())
    log_.info("metrics", fmt::format("{} is written again", path));
  else
    log_.warning("metrics", fmt::format("{} cannot be written, which is tried again: {}", path, trouble));
}

}  // namespace contourd
