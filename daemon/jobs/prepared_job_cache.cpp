#include "daemon/jobs/prepared_job_cache.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "daemon/spool/copied_originals.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// A mark tells of a symbolic link, not of what it leads to.
bool has_links(const JobFiles& files) {
  const auto is_link = [](const fs::path& path) { return fs::is_symlink(fs::symlink_status(path)); };
  try {
    return is_link(files.model) || std::ranges::any_of(parts_of(files), is_link);
  } catch (const std::exception&) {
    return true;  // nobody knows
  }
}

}  // namespace

void PreparedJobCache::keep(const JobFiles& files, const std::string& mark, PreparedJob job) {
  kept_.reset();
  if (mark.empty() || mark != mark_of(files) || has_links(files)) return;
  kept_ = Kept{files.model, mark, std::move(job)};
}

std::optional<PreparedJob> PreparedJobCache::take(const JobFiles& files,
                                                  const std::optional<JobSettings>& settings) {
  auto kept = std::exchange(kept_, std::nullopt);
  if (!kept || !settings || kept->job.settings != *settings || kept->mark != mark_of(files))
    return std::nullopt;
  PreparedJob job = std::move(kept->job);
  job.plan.job = files.name;
  job.first_mask_at = std::chrono::steady_clock::now();
  job.summary.prepared_before = true;
  return job;
}

void PreparedJobCache::forget(const JobFiles& files) {
  if (kept_ && kept_->model == files.model) kept_.reset();
}

}  // namespace contourd
