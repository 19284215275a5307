#include "daemon/control/metrics_file.hpp"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "daemon/system/new_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// The lowest priority: any other work comes first.
constexpr int kMetricsNiceness = 19;

// Replaces the file atomically. Returns the reason for a failure; empty on success.
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
      exists_(std::make_shared<bool>(false)),
      worker_(loop, "contourd-metric", kMetricsNiceness) {
  timer_ = loop_.at(std::chrono::steady_clock::now(), "the metrics' timer", [this] { update(); });
}

MetricsFile::~MetricsFile() {
  worker_.run(
      [path = path_, exists = exists_] {
        std::error_code error;
        return *exists && fs::remove(path, error);
      },
      [](bool) {});
}

void MetricsFile::update() {
  timer_ = loop_.at(std::chrono::steady_clock::now() + interval_, "the metrics' timer", [this] { update(); });
  if (writing_) return;  // the disk is slow: try at the next interval
  const std::string text = make_();
  if (text != written_) write(text);
}

void MetricsFile::write(const std::string& text) {
  writing_ = true;
  worker_.run(
      [path = path_, exists = exists_, text] {
        std::string trouble = replace(path, text);
        *exists = *exists || trouble.empty();
        return trouble;
      },
      [this, text](const std::string& trouble) {
        writing_ = false;
        if (trouble.empty()) written_ = text;
        report(trouble);
      });
}

void MetricsFile::report(const std::string& trouble) {
  if (std::exchange(trouble_, trouble) == trouble) return;
  const std::string path = printable(path_.string());
  if (trouble.empty())
    log_.info("metrics", fmt::format("{} is written again", path));
  else
    log_.warning("metrics", fmt::format("{} cannot be written and is tried again: {}", path, trouble));
}

}  // namespace contourd
