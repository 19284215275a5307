#include "daemon/spool/upload_state.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "daemon/config/job_ticket.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// Maximum number of missing files that are reported.
constexpr std::size_t kMaxMissing = 10;

enum class Writers { None, Some, Unknown };

// Finds out if a process writes the file: the kernel grants a read lease (fcntl(2), F_SETLEASE) only while no
// process has the file open for writing.
Writers writers_of(const fs::path& path) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW));
  if (!file.valid()) return Writers::Unknown;
  if (::fcntl(file.get(), F_SETLEASE, F_RDLCK) == 0) return Writers::None;  // the lease ends on close
  return errno == EAGAIN ? Writers::Some : Writers::Unknown;
}

// Returns the plate's missing files, at most kMaxMissing. Returns none if its plate.json cannot be used: the
// job's check reports that later.
std::vector<std::string> missing_models(const fs::path& plate) {
  std::vector<std::string> missing;
  try {
    for (const ModelTicket& model : load_plate_ticket(plate / kPlateTicket, Links::Refuse).models) {
      std::error_code code;
      const bool there = fs::exists(fs::symlink_status(plate / model.file, code));
      if (missing.size() == kMaxMissing) break;
      if (!there && std::find(missing.begin(), missing.end(), model.file) == missing.end())
        missing.push_back(model.file);
    }
  } catch (const ConfigError&) {
  }
  return missing;
}

UploadState state_of_model(const JobFiles& files) {
  struct stat status {};
  if (::lstat(files.model.c_str(), &status) != 0) return {};
  UploadState state;
  state.is_there = true;
  state.bytes = static_cast<std::uintmax_t>(status.st_size);
  const Writers writers = writers_of(files.model);
  state.being_written =
      writers == Writers::Some || (files.ticket && writers_of(*files.ticket) == Writers::Some);
  state.known_to_be_whole = (state.bytes > 0 && writers == Writers::None) || !S_ISREG(status.st_mode);
  return state;
}

UploadState state_of_plate(const fs::path& path) {
  UploadState state;
  state.is_there = state.is_plate = true;
  std::error_code code;
  // Without plate.json the folder is not a plate, or not yet: its other files do not matter.
  if (!fs::exists(fs::symlink_status(path / kPlateTicket, code)) && code != std::errc::permission_denied) {
    state.missing = {kPlateTicket};
    return state;
  }
  state.known_to_be_whole = !code;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, code)) {
    struct stat status {};
    if (::lstat(entry.path().c_str(), &status) != 0 || !S_ISREG(status.st_mode)) continue;
    const auto bytes = static_cast<std::uintmax_t>(status.st_size);
    const Writers writers = writers_of(entry.path());
    state.bytes += bytes;
    state.being_written = state.being_written || writers == Writers::Some;
    state.known_to_be_whole = state.known_to_be_whole && bytes > 0 && writers == Writers::None;
  }
  if (!state.being_written) state.missing = missing_models(path);
  return state;
}

}  // namespace

UploadState upload_state(const SpoolFolders& folders, const std::string& file) {
  const JobFiles files = folders.files_of(SpoolFolder::Incoming, file);
  if (files.plate) return state_of_plate(files.model);
  return is_model_name(file) ? state_of_model(files) : UploadState{};
}

bool is_unfinished(const JobFiles& job) {
  if (job.plate) {
    const UploadState state = state_of_plate(job.model);
    return state.being_written || !state.missing.empty();
  }
  return state_of_model(job).being_written;
}

}  // namespace contourd
