#include "daemon/jobs/prepared_job_cache.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "daemon/spool/copied_originals.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// True if one of the files is a symbolic link: a mark describes the link, not its target.
bool has_links(const JobFiles& files) {
  const auto is_link = [](const fs::path& path) { return fs::is_symlink(fs::symlink_status(path)); };
  try {
    return is_link(files.model) || std::ranges::any_of(parts_of(files), is_link);
  } catch (const std::exception&) {
    return true;  // unknown: assume the worse
  }
}

}  // namespace

void PreparedJobCache::keep(const JobFiles& files, const std::string& mark, PreparedJob job) {
  entry_.reset();
  if (mark.empty() || mark != mark_of(files) || has_links(files)) return;
  entry_ = Entry{files.model, mark, std::move(job)};
}

std::optional<PreparedJob> PreparedJobCache::take(const JobFiles& files,
                                                  const std::optional<JobSettings>& settings) {
  auto entry = std::exchange(entry_, std::nullopt);
  if (!entry || !settings || entry->job.settings != *settings || entry->mark != mark_of(files))
    return std::nullopt;
  PreparedJob job = std::move(entry->job);
  job.plan.job = files.name;
  job.first_mask_at = std::chrono::steady_clock::now();
  job.summary.prepared_before = true;
  return job;
}

void PreparedJobCache::forget(const JobFiles& files) {
  if (entry_ && entry_->model == files.model) entry_.reset();
}

}  // namespace contourd
