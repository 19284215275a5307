// The printer service's answers to the control socket.
#include <fmt/format.h>
#include <pwd.h>

#include <array>
#include <cstdio>
#include <memory>

#include "daemon/printer_service.hpp"

namespace contourd {
namespace {

// A reply does not grow with what lies in the spool: it is made while a light waits.
constexpr std::size_t kMostQueued = 1'000, kMostIncomplete = 10;

double seconds(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

template <typename All, typename Take>
void for_first(const All& all, std::size_t most, const Take& take) {
  for (auto each = all.begin(); each != all.end() && most > 0; ++each, --most)
    take(*each);
}

std::size_t beyond(std::size_t all, std::size_t most) {
  return all > most ? all - most : 0;
}

// By the system's own list alone: a directory service could keep the loop waiting. The number of whom that
// does not know.
std::string user_name(uid_t user) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> users(std::fopen("/etc/passwd", "re"), std::fclose);
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> buffer{};
  while (users && ::fgetpwent_r(users.get(), &entry, buffer.data(), buffer.size(), &found) == 0) {
    if (entry.pw_uid == user) return fmt::format("{} ({})", entry.pw_name, user);
  }
  return std::to_string(user);
}

}  // namespace

std::map<std::string, ControlServer::Method> PrinterService::methods() {
  return {{"status", [this] { return status(); }},
          {"queue",
           [this] {
             Json files = Json::array();
             for_first(queue_, kMostQueued, [&](const QueuedJob& job) { files.push_back(job.file); });
             return Json{{"queue", files},
                         {"more", beyond(queue_.size(), kMostQueued)},
                         {"arriving", spool_.arriving(kMostQueued)}};
           }},
          {"history",
           [this] {
             Json jobs = Json::array();
             for (const EndedJob& job : ended_) {
               jobs.push_back(ended_json(job));
               jobs.back()["analysis"] = job.analysis;
             }
             return Json{{"ended", jobs}};
           }},
          {"pause",
           [this] {
             require_print("pause");
             if (process_.next_pause().empty()) throw ControlRefusal(why_it_ends());
             process_.pause();
             return status();
           }},
          {"resume",
           [this] {
             if (held_ && (!active_ || finishing())) return resume_queue();
             require_print("resume");
             const PrintState state = process_.state();
             const bool pausing = state == PrintState::Raising || process_.pause_pending();
             if (state != PrintState::Paused && state != PrintState::Held && !pausing) {
               throw ControlRefusal("the print is not paused");
             }
             if (const std::string hindrance = machine_.hindrance(); !hindrance.empty()) {
               throw ControlRefusal("the print cannot go on: " + hindrance);
             }
             let_go();
             process_.resume();
             return status();
           }},
          {"cancel", [this] { return cancel(); }},
          {"plate_cleared", [this] {
             if (active_ && !finishing())
               throw ControlRefusal(fmt::format("{} is being printed", active_->files.name));
             if (plate_occupant_) log_.info("plate", "the plate is clear");
             set_plate_occupant(std::nullopt);
             let_go();
             pump();
             return status();
           }}};
}

void PrinterService::called(const std::string& method, const ControlServer::Peer& peer) const {
  if (method == "status" || method == "queue" || method == "history") return;
  log_.info("command",
            fmt::format("{}, says user {} (process {})", method, user_name(peer.user), peer.process),
            {{"PEER_UID", std::to_string(peer.user)}, {"PEER_PID", std::to_string(peer.process)}});
}

bool PrinterService::finishing() const {
  return active_ && active_->prepared && process_.state() == PrintState::Idle;
}

void PrinterService::require_print(std::string_view what) const {
  if (process_.state() == PrintState::Idle)
    throw ControlRefusal(fmt::format("there is no print to {}", what));
}

std::string PrinterService::why_it_ends() const {
  if (process_.canceled()) return "the print is being cancelled";
  const PrintState state = process_.state();
  if (state == PrintState::Parking) return "all layers are printed, the plate goes up";
  if (state == PrintState::Ending) return "the print is over";
  return "the last layer is under way, the print ends by itself";
}

PrinterService::Json PrinterService::resume_queue() {
  if (const std::string hindrance = machine_.hindrance(); !hindrance.empty()) {
    throw ControlRefusal("the queue cannot go on: " + hindrance);
  }
  let_go();
  pump();
  return status();
}

PrinterService::Json PrinterService::cancel() {
  if (!active_ || finishing()) throw ControlRefusal("there is no print to cancel");
  if (active_->prepared) {
    const PrintState state = process_.state();
    const bool over = state == PrintState::Parking || state == PrintState::Ending;
    if (over && !process_.canceled()) throw ControlRefusal(why_it_ends());
    process_.cancel();
  } else {
    active_->cancel_wanted = true;
  }
  return status();
}

PrinterService::Json PrinterService::ended_json(const EndedJob& job) {
  return {{"job", job.name}, {"outcome", job.outcome}, {"reason", job.reason}};
}

PrinterService::Json PrinterService::job_json() const {
  Json job{{"name", active_->files.name}};
  job["analysis"] = active_->analysis;
  if (process_.state() == PrintState::Idle) return job;
  const JobSummary& summary = active_->prepared->summary;
  job["layer"] = process_.layer() + 1;
  job["layers"] = summary.layers.count;
  job["layers_done"] = layers_exposed(active_->layers);
  job["height_mm"] = to_millimeters(process_.layer_top()).count();
  job["total_height_mm"] = summary.height_mm;
  job["layer_height_um"] = to_millimeters(process_.layer_thickness()).count() * 1000;
  job["elapsed_s"] = seconds(clock_.now() - active_->started);
  job["time_left_s"] = seconds(process_.time_left());
  job["pause_pending"] = process_.pause_pending();
  job["pause"] = process_.pause_pending() ? Json(process_.next_pause()) : Json();
  job["interruption"] = process_.interruption().empty() ? Json() : Json(process_.interruption());
  return job;
}

PrinterService::Json PrinterService::status() const {
  std::string_view state = name_of(process_.state());
  if (active_ && process_.state() == PrintState::Idle) state = finishing() ? "finishing" : "preparing";
  Json status{{"printer", config_.name}, {"state", state}};
  status["job"] = active_ ? job_json() : Json();
  status["queued"] = queue_.size();
  const auto& incomplete = spool_.incomplete();
  status["incomplete"] = Json::object();
  for_first(incomplete, kMostIncomplete,
            [&](const auto& plate) { status["incomplete"][plate.first] = plate.second; });
  status["incomplete_more"] = beyond(incomplete.size(), kMostIncomplete);
  status["postponed"] = Json::object();
  std::size_t postponed = 0;
  for (const QueuedJob& job : queue_) {
    if (!job.postponed.empty() && ++postponed <= kMostIncomplete)
      status["postponed"][job.file] = job.postponed;
  }
  status["postponed_more"] = beyond(postponed, kMostIncomplete);
  const auto& passed_over = spool_.passed_over();
  status["passed_over"] = Json::object();
  for_first(passed_over, kMostIncomplete,
            [&](const auto& each) { status["passed_over"][each.first] = sentence_for(each.second); });
  status["passed_over_more"] = beyond(passed_over.size(), kMostIncomplete);
  const auto& originals = spool_.originals();
  status["deletable"] = Json::array();
  for_first(originals, kMostIncomplete,
            [&](const std::string& file) { status["deletable"].push_back(file); });
  status["deletable_more"] = beyond(originals.size(), kMostIncomplete);
  status["plate"] = plate_occupant_ ? "occupied" : "clear";
  status["plate_job"] = plate_occupant_ ? Json(*plate_occupant_) : Json();
  const std::string hindrance = machine_.hindrance();
  status["hindrance"] = hindrance.empty() ? Json() : Json(hindrance);
  status["held"] = held_ ? Json(hold_sentence()) : Json();
  status["waiting_for"] = waiting_for_.empty() ? Json() : Json(waiting_for_);
  status["last"] = ended_.empty() ? Json() : ended_json(ended_.back());
  return status;
}

}  // namespace contourd
