#include "daemon/ctl/models/spooled_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

constexpr std::array kFolders{SpoolFolder::Incoming, SpoolFolder::Printing, SpoolFolder::Done,
                              SpoolFolder::Failed};
// Kinds of names, in the order in which they are tried.
enum class NameKind { File, Name, Readable };
constexpr std::array kNameKinds{NameKind::File, NameKind::Name, NameKind::Readable};
// Limit of jobs that a message names.
constexpr std::size_t kMostNamed = 5;

bool is_called(const std::string& file, const std::string& name, NameKind kind) {
  switch (kind) {
    case NameKind::File:
      return file == name;
    case NameKind::Name:
      return job_name_of(file) == name;
    case NameKind::Readable:
      return printable(file) == name || printable(job_name_of(file)) == name;
  }
  return false;
}

[[noreturn]] void fail(const fs::path& folder, const std::error_code& code) {
  throw std::system_error(code, "cannot read " + folder.string());
}

// Returns the files and folders in `folder` that may be jobs and have this name.
std::vector<std::string> found_in(const SpoolFolders& spool, SpoolFolder folder, const std::string& name,
                                  NameKind kind) {
  std::vector<std::string> found;
  std::error_code code;
  fs::directory_iterator entry(spool.path(folder), code), end;
  for (; !code && entry != end; entry.increment(code)) {
    const std::string file = entry->path().filename().string();
    if (is_called(file, name, kind) && (is_model_name(file) || spool.is_plate(folder, file)))
      found.push_back(file);
  }
  if (code) fail(spool.path(folder), code);
  std::ranges::sort(found);
  return found;
}

[[noreturn]] void refuse_many(const std::string& name, SpoolFolder folder,
                              const std::vector<std::string>& found) {
  std::string files;
  for (std::size_t i = 0; i < std::min(found.size(), kMostNamed); ++i)
    files += (i == 0 ? "" : ", ") + in_quotes(found[i]);
  throw UsageError(
      fmt::format("more than one job in {} is called {}: {}", name_of(folder), in_quotes(name), files));
}

}  // namespace

std::string name_of(SpoolFolder folder) {
  return SpoolFolders("").path(folder).string();
}

std::optional<SpooledJob> find_job(const SpoolFolders& spool, const std::string& name) {
  for (const NameKind kind : kNameKinds) {
    std::optional<SpooledJob> job;
    for (const SpoolFolder folder : kFolders) {
      const std::vector<std::string> found = found_in(spool, folder, name, kind);
      if (found.empty()) continue;
      if (job) {
        job->others.push_back(folder);
        continue;
      }
      if (found.size() > 1) refuse_many(name, folder, found);
      job = SpooledJob{spool.files_of(folder, found.front()), folder};
    }
    if (job) return job;
  }
  return std::nullopt;
}

}  // namespace contourd::ctl
