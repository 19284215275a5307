#include "daemon/control/waiting_job_control.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "daemon/config/job_ticket.hpp"
#include "daemon/control/file_pieces.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/placement/job_settings.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {

using Json = WaitingJobControl::Json;

namespace {

using TicketResult = std::variant<Json, ControlRefusal>;

ControlRefusal refusal_for_plate(const std::string& file) {
  return ControlRefusal(
      fmt::format("{} is a plate: its settings are in its {}", in_quotes(file), kPlateTicket));
}

Json reply_with(const std::string& file, Json ticket) {
  return {{"file", file}, {"ticket", std::move(ticket)}};
}

// Reads the ticket of incoming/`file`. Blocks. Any thread.
TicketResult read_ticket(const Spool& spool, const std::string& file) {
  const JobFiles files = spool.files_of(Spool::Folder::Incoming, file);
  if (files.plate) return refusal_for_plate(file);
  if (!files.ticket) return reply_with(file, nullptr);
  try {
    Json ticket(JsonDocument::from_file(*files.ticket, files.links).value());
    if (ticket.dump(-1, ' ', true, Json::error_handler_t::replace).size() <=
        WaitingJobControl::kMostTicketBytes)
      return reply_with(file, std::move(ticket));
    return ControlRefusal(fmt::format("the ticket of {} has more than {} bytes: edit it in incoming",
                                      in_quotes(file), WaitingJobControl::kMostTicketBytes));
  } catch (const ConfigError& error) {
    return ControlRefusal(error.in_one_line());
  }
}

std::string ticket_text(const Json& ticket) {
  return ticket.dump(2, ' ', true, Json::error_handler_t::replace) + "\n";
}

void write_ticket(const std::filesystem::path& file, const std::string& text) {
  NewFile ticket(file.parent_path());
  ticket.let_group_read();
  ticket.write(text);
  ticket.replace(file.filename().string());
  sync_folder(file.parent_path());
}

// Returns the files of a waiting model, with the place of its ticket. Blocks. Throws ControlRefusal.
JobFiles files_for_ticket(const Spool& spool, const PrinterConfig& config, const std::string& file) {
  JobFiles files = spool.files_of(Spool::Folder::Incoming, file);
  if (files.plate) throw refusal_for_plate(file);
  files.ticket = spool.folder(Spool::Folder::Incoming) / (files.name + ".json");
  if (!spool.is_waiting(file)) throw ControlRefusal(fmt::format("no job {} waits", in_quotes(file)));
  if (SpoolFolders(config.spool_folder).shares_ticket(files))
    throw ControlRefusal(
        fmt::format("the ticket of {} belongs to another model, too: rename one of them", in_quotes(file)));
  return files;
}

// Returns the settings of incoming/`file` by a new ticket. Blocks. Any thread.
std::variant<JobSettings, ControlRefusal> settings_with(const Spool& spool, const PrinterConfig& config,
                                                        const std::string& file, const std::string& ticket) {
  constexpr const char* kName = "the ticket";
  try {
    (void)files_for_ticket(spool, config, file);
    return settings_by(parse_job_ticket(ticket, kName), kName, config);
  } catch (const ControlRefusal& refusal) {
    return refusal;
  } catch (const ConfigError& error) {
    return ControlRefusal(error.in_one_line());
  } catch (const JobRefused& refusal) {
    return ControlRefusal(refusal.what());
  }
}

// Puts a ticket beside incoming/`file`. Blocks. To be called on the spool's thread, on which jobs are also
// claimed.
TicketResult put_ticket(const Spool& spool, const PrinterConfig& config, const std::string& file,
                        const Json& ticket) {
  try {
    write_ticket(*files_for_ticket(spool, config, file).ticket, ticket_text(ticket));
  } catch (const ControlRefusal& refusal) {
    return refusal;
  } catch (const std::system_error& error) {
    return ControlRefusal(fmt::format("the ticket of {} cannot be written: {}", in_quotes(file),
                                      why_not_written(error.code())));
  }
  return reply_with(file, ticket);
}

}  // namespace

ControlMethods WaitingJobControl::methods() {
  const ControlParameter job =
      ControlParameter::text("job",
                             "the job: its file in `incoming/`, its name, or the printable form of either")
          .described_as("the name of a waiting job")
          .needed();
  return {{"ticket",
           {.description = "Reports the ticket of a waiting job.",
            .parameters = {job},
            .call_later = [this](const Json& given, const ControlCaller&,
                                 ControlMethod::Later later) { ticket(given, std::move(later)); }}},
          {"queue_ticket",
           {.description = "Replaces the ticket of a waiting job, which is then checked again.",
            .parameters = {job, ControlParameter::object("ticket", "the new ticket, as in a file").needed()},
            .changes = true,
            .call_later = [this](const Json& given, const ControlCaller&,
                                 ControlMethod::Later later) { replace_ticket(given, std::move(later)); }}},
          {"preview",
           {.description = "Draws a waiting job with its supports, and returns the picture in pieces of a "
                           "PNG file.",
            .parameters = {job, piece_parameter("picture", "the picture, for the next piece"),
                           piece_parameter("from", "position of the piece: the number of bytes received")},
            .call_later = [this](const Json& given, const ControlCaller&, ControlMethod::Later later) {
              preview(given, std::move(later));
            }}}};
}

const WaitingJob& WaitingJobControl::job_of(const Json& given) const {
  const WaitingJob& job =
      parts_.queue.jobs()[parts_.queue_control.number_of(given["job"].get<std::string>())];
  if (job.check == WaitingJob::Check::Refused)
    throw ControlRefusal(fmt::format("{} is already being moved to failed", in_quotes(job.file)));
  return job;
}

void WaitingJobControl::ticket(const Json& given, ControlMethod::Later later) {
  parts_.spool.run([&spool = parts_.spool, file = job_of(given).file] { return read_ticket(spool, file); },
                   std::move(later));
}

void WaitingJobControl::replace_ticket(const Json& given, ControlMethod::Later later) {
  const std::string file = job_of(given).file;
  if (trying_) throw ControlRefusal("the ticket of another job is being tried; try again");
  trying_ = true;
  parts_.spool.run([&spool = parts_.spool, &config = config_, file,
                    text = ticket_text(given["ticket"])] { return settings_with(spool, config, file, text); },
                   [this, file, ticket = given["ticket"], later = std::move(later)](
                       const std::variant<JobSettings, ControlRefusal>& settings) mutable {
                     if (const auto* const refusal = std::get_if<ControlRefusal>(&settings)) {
                       trying_ = false;
                       return later(*refusal);
                     }
                     try_ticket({file, std::move(ticket)}, std::get<JobSettings>(settings), std::move(later));
                   });
}

// A ticket with which the job would be refused must not take it out of the queue.
void WaitingJobControl::try_ticket(NewTicket ticket, const JobSettings& settings,
                                   ControlMethod::Later later) {
  const std::string file = ticket.file;
  parts_.reader.try_settings(
      file, settings,
      [this, ticket = std::move(ticket), later = std::move(later)](const std::string& refusal) mutable {
        trying_ = false;
        if (!refusal.empty()) return later(ControlRefusal(refusal));
        parts_.spool.run(
            [&spool = parts_.spool, &config = config_, ticket = std::move(ticket)] {
              return put_ticket(spool, config, ticket.file, ticket.json);
            },
            std::move(later));
      });
}

namespace {

Json piece_of(const std::string& file, std::uint64_t number, const std::vector<std::uint8_t>& png,
              std::size_t from) {
  Json reply{{"picture", number}, {"file", file}};
  add_piece(reply, png, from);
  return reply;
}

}  // namespace

void WaitingJobControl::preview(const Json& given, ControlMethod::Later later) {
  const WaitingJob& job = job_of(given);
  const auto wanted = given.value("picture", std::uint64_t{0}), from = given.value("from", std::uint64_t{0});
  if (wanted == 0 && from != 0) throw InvalidParameters("from needs picture");
  const auto kept = std::ranges::find_if(pictures_, [&](const Picture& each) {
    return each.file == job.file && each.checked == job.check_number &&
           (wanted == 0 || each.number == wanted);
  });
  if (kept != pictures_.end()) {
    if (from >= kept->png.size())
      throw InvalidParameters(fmt::format("from must be below {}, the size of picture {} in bytes",
                                          kept->png.size(), kept->number));
    return later(piece_of(kept->file, kept->number, kept->png, from));
  }
  if (wanted != 0) throw ControlRefusal(fmt::format("picture {} is no longer kept", wanted));
  if (job.check != WaitingJob::Check::Passed)
    throw ControlRefusal(fmt::format("{} is not checked yet", in_quotes(job.file)));
  if (std::exchange(drawing_, true)) {
    throw ControlRefusal("the picture of another job is being drawn; try again");
  }
  parts_.reader.draw(job.file, [this, picture = Picture{.file = job.file, .checked = job.check_number},
                                later = std::move(later)](const DrawnJob& drawn_job) mutable {
    drawing_ = false;
    drawn(std::move(picture), drawn_job, later);
  });
}

void WaitingJobControl::drawn(Picture picture, const DrawnJob& job, const ControlMethod::Later& later) {
  if (job.png.empty())
    return later(ControlRefusal(fmt::format("{} cannot be drawn: {}", in_quotes(picture.file), job.trouble)));
  picture.number = ++pictures_drawn_;
  picture.png = job.png;
  std::erase_if(pictures_, [&](const Picture& each) { return each.file == picture.file; });
  if (pictures_.size() >= kMostPictures) pictures_.pop_front();
  pictures_.push_back(std::move(picture));
  later(piece_of(pictures_.back().file, pictures_.back().number, pictures_.back().png, 0));
}

}  // namespace contourd
