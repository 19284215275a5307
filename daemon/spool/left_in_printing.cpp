#include "daemon/spool/left_in_printing.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "core/formats/model_reader.hpp"
#include "daemon/spool/job_moves.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// Moves the model's ticket to printing/ if it is still in incoming/ because a power cut separated the two
// moves. Such a ticket has an older change time than its model, which was moved first.
void bring_ticket_of(const SpoolFolders& folders, const std::string& file) {
  const JobFiles job = folders.files_of(SpoolFolder::Printing, file);
  const std::string ticket = job.name + ".json";
  const fs::path left = folders.path(SpoolFolder::Incoming) / ticket;
  std::error_code code;  // a ticket that cannot be moved stays for the case that its model is submitted again
  if (job.plate || job.ticket || !folders.models_of_ticket(ticket).empty()) return;
  if (change_time(left) < change_time(job.model))
    fs::rename(left, folders.path(SpoolFolder::Printing) / ticket, code);
}

// Returns the folder for a file in printing/ that belongs to no job there: a ticket goes to its model.
SpoolFolder folder_of_lost(const SpoolFolders& folders, const std::string& ticket) {
  if (!ticket.ends_with(".json")) return SpoolFolder::Failed;
  std::error_code code;
  const auto lacks_it = [&](const fs::path& model) {
    return fs::exists(fs::symlink_status(model, code)) &&
           !fs::exists(fs::symlink_status(model.parent_path() / ticket, code));
  };
  for (const fs::path& model : folders.models_of_ticket(ticket)) {
    if (lacks_it(model)) return SpoolFolder::Incoming;
  }
  const bool is_done = std::ranges::any_of(model_extensions(), [&](std::string_view extension) {
    return lacks_it((folders.path(SpoolFolder::Done) / ticket).replace_extension(extension));
  });
  return is_done ? SpoolFolder::Done : SpoolFolder::Failed;
}

}  // namespace

std::vector<JobFiles> jobs_left_in_printing(const SpoolFolders& folders) {
  std::vector<JobFiles> jobs;
  std::vector<fs::path> others;
  for (const fs::directory_entry& entry : fs::directory_iterator(folders.path(SpoolFolder::Printing))) {
    const std::string file = entry.path().filename().string();
    if (is_model_name(file) || folders.is_plate(SpoolFolder::Printing, file)) {
      bring_ticket_of(folders, file);
      jobs.push_back(folders.files_of(SpoolFolder::Printing, file));
    } else {
      others.push_back(entry.path());
    }
  }
  for (const fs::path& other : others) {
    const bool belongs_to_job =
        std::any_of(jobs.begin(), jobs.end(), [&](const JobFiles& job) { return job.ticket == other; });
    if (belongs_to_job) continue;
    const fs::path place = folders.path(folder_of_lost(folders, other.filename())) / other.filename();
    std::error_code code;  // a file that cannot be moved waits for the next start
    if (!fs::exists(fs::symlink_status(place, code))) fs::rename(other, place, code);
  }
  return jobs;
}

}  // namespace contourd
