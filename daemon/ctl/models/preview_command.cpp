#include "daemon/ctl/models/model_commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/image/preview.hpp"
#include "core/layers/layers.hpp"
#include "daemon/client/control_defaults.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/models/layer_measurements.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/models/supported_model.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/picture_output.hpp"
#include "daemon/ctl/terminal/suggestions.hpp"
#include "daemon/formats/model_names.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/prepare/job_content.hpp"
#include "daemon/report/job_picture.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/system/memory_room.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

struct PreviewOptions {
  std::string subject;       // a model's file, or a job's name
  std::optional<int> layer;  // draw this layer's mask, counted from 1; nullopt: the shaded model
  // Configuration of the printer; nullopt: the installed one, if one is needed.
  std::optional<std::filesystem::path> printer;
  std::optional<std::filesystem::path> ticket;  // for a model's file
  std::optional<std::filesystem::path> spool;   // nullopt: ask contourd
  std::optional<std::filesystem::path> output;  // a PNG file, or "-"; nullopt: draw in the terminal
};

namespace fs = std::filesystem;

// --- jobs of the spool

struct SpooledJob {
  JobFiles files;
  SpoolFolder folder{};
  // Other folders with a job of this name.
  std::vector<SpoolFolder> others{};
};

constexpr std::array kFolders{SpoolFolder::Incoming, SpoolFolder::Printing, SpoolFolder::Done,
                              SpoolFolder::Failed};
// Kinds of names, in the order in which they are tried.
enum class NameKind { File, Name, Readable };
constexpr std::array kNameKinds{NameKind::File, NameKind::Name, NameKind::Readable};
// Limit of jobs that a message names.
constexpr std::size_t kMostNamed = 5;

// Returns "incoming" and so on.
std::string name_of(SpoolFolder folder) {
  return SpoolFolders("").path(folder).string();
}

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
  if (code) throw std::system_error(code, "cannot read " + spool.path(folder).string());
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

// Finds a job by its name, its file's name, or the printable form of either; a waiting or printing job comes
// before others. The job may be moved at any time. Returns nullopt if there is none. Throws UsageError if the
// name fits several jobs of a folder, and std::system_error if there is no spool or a folder cannot be read.
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

// --- the subject

struct PreviewSubject {
  JobFiles files;
  std::string title;  // printable
  bool spooled = false;
};

bool is_there(const fs::path& path) {
  std::error_code code;
  return fs::exists(fs::symlink_status(path, code));
}

PreviewSubject file_subject(const PreviewOptions& options) {
  const fs::path path = options.subject;
  look_at_models(
      path,
      models_named_in(options.ticket));  // gives the same messages for unreadable files as other commands
  return {{model_stem(path.filename().string()), path, options.ticket}, printable(path.filename().string())};
}

std::string elsewhere(const SpooledJob& job) {
  std::string folders;
  for (const SpoolFolder folder : job.others)
    folders += fmt::format("{}{}", folders.empty() ? "" : " and in ", name_of(folder));
  return folders.empty() ? "" : fmt::format(" (there is another in {})", folders);
}

PreviewSubject job_subject(const ClientOptions& client, const PreviewOptions& options) {
  const SpoolFolders spool = [&] {
    try {
      return SpoolFolders(find_spool(client, options.spool));
    } catch (const DaemonError& error) {
      throw DaemonError(fmt::format(
          "there is no file {}, and jobs cannot be looked up: {}; use --spool to name the spool's "
          "folder",
          in_quotes(options.subject), error.what()));
    }
  }();
  const std::optional<SpooledJob> job = find_job(spool, options.subject);
  if (!job) {
    throw std::system_error(std::make_error_code(std::errc::no_such_file_or_directory),
                            fmt::format("neither a file nor a job in {} is called {}", spool.root().string(),
                                        in_quotes(options.subject)));
  }
  if (options.ticket) throw UsageError("--ticket needs a model's file: a job has its own ticket");
  return {job->files,
          fmt::format("{}, in {}{}", printable(job->files.name), name_of(job->folder), elsewhere(*job)),
          true};
}

// True if the subject is a file: it contains a slash, or it names an existing file.
bool is_file(const std::string& subject) {
  std::error_code code;
  return subject.find('/') != std::string::npos || (is_there(subject) && !fs::is_directory(subject, code));
}

PreviewSubject subject_of(const ClientOptions& client, const PreviewOptions& options) {
  return is_file(options.subject) ? file_subject(options) : job_subject(client, options);
}

// --- the picture

PrinterConfig printer_for(const PreviewOptions& options, std::string_view what) {
  const fs::path file = options.printer.value_or(kDefaultConfig);
  if (!options.printer && !is_there(file)) {
    throw UsageError(fmt::format("{} needs a printer's configuration, but there is no {}; use --printer FILE",
                                 what, file.string()));
  }
  return load_printer_config(file, Places::Elsewhere);
}

NotedPicture mask_of_layer(const PreviewSubject& subject, PreparedJob job, int number) {
  const std::vector<Nanometers>& layers = job.plan.expected_layers;
  if (static_cast<std::size_t>(number) > layers.size())
    throw UsageError(
        fmt::format("there is no layer {} of {}: it has {}", number, subject.title, layers.size()));
  const auto index = static_cast<std::size_t>(number) - 1;
  const Nanometers middle = middles_of(layers)[index], bottom = middle - layers[index] / 2;
  ContourEngine& engine = *job.analysis_engine;
  MaskBudget budget(MaskBudget::Clock::now() + job.analysis.mask_budget.value_or(job.plan.mask_budget));
  const Mask* const mask = engine.mask_within(middle, budget);
  if (mask == nullptr) {
    throw ModelError(fmt::format("{}: the mask of layer {} takes far longer than mask_budget_ms",
                                 subject.files.model.string(), number));
  }
  const double mm2 = engine.coverage().lit_area() * job.plan.pixel_area_mm2;
  return {
      *mask,
      fmt::format("{}: layer {} of {}, {:.3f} to {:.3f} mm, {:.2f} mm²", subject.title, number, layers.size(),
                  to_millimeters(bottom).count(), to_millimeters(bottom + layers[index]).count(), mm2),
      true};
}

std::string size_text(double x, double y, double z) {
  return fmt::format("{:.6g} x {:.6g} x {:.6g} mm", x, y, z);
}

NotedPicture shaded_job(const PreviewSubject& subject, const PreparedJob& job) {
  const JobSummary& summary = job.summary;
  std::size_t parts = 0;
  for (const ModelSummary& model : summary.models)
    parts += model.centers.size();
  const ModelSummary& first = summary.models.front();
  const std::string what = summary.plate
                               ? fmt::format("{} models, {:.6g} mm high", parts, summary.height_mm)
                               : fmt::format("{}{}", parts > 1 ? fmt::format("{} of ", parts) : "",
                                             size_text(first.size_x_mm, first.size_y_mm, first.size_z_mm));
  return {draw_job(*job.plan.engine, summary.supports ? &*summary.supports : nullptr).picture,
          fmt::format("{}: {}, layers {}", subject.title, what, layers_text(job.plan.expected_layers))};
}

std::vector<Facet> facets_of(const PreviewSubject& subject) {
  const JobFiles& files = subject.files;
  if (!subject.spooled) {
    Model model = read_turned_model(files.model, std::nullopt, {});
    print_warnings(model.warnings);
    return std::move(model.facets);
  }
  try {
    JobContent content(files, JobTicket{}, false);
    content.read(DisplayGeometry{}, memory_room(std::nullopt), {});
    return content.take_facets(0);
  } catch (const JobRefused& refusal) {
    throw ModelError(files.model.string() + ": " + refusal.what());
  }
}

NotedPicture shaded_model(const PreviewSubject& subject) {
  const std::vector<Facet> facets = facets_of(subject);
  if (facets.empty()) throw ModelError(subject.files.model.string() + ": the file holds no facets");
  const Bounds bounds = bounds_of(facets);
  const Millimeters top{std::numeric_limits<double>::infinity()};
  return {render_preview(facets, top, kJobPictureSide, kJobPictureSide),
          fmt::format("{}: {}, {} facets", subject.title,
                      size_text(bounds.size_x(), bounds.size_y(), bounds.size_z()), facets.size())};
}

NotedPicture draw(const PreviewSubject& subject, const PreviewOptions& options) {
  const JobFiles& files = subject.files;
  if (options.layer)
    return mask_of_layer(subject, prepare_model(files, printer_for(options, "--layer")), *options.layer);
  const bool pictured = !files.plate && holds_layers(files.model, models_named_in(files.ticket));
  if (!options.printer && !files.ticket && !files.plate && !pictured) return shaded_model(subject);
  const PrinterConfig printer = printer_for(options, files.plate ? "a plate"
                                                     : pictured  ? "a file with finished layers"
                                                                 : "a ticket");
  try {
    return shaded_job(subject, prepare_model(files, printer));
  } catch (const ModelError& error) {
    if (!subject.spooled || files.plate || pictured) throw;
    // A job that cannot be printed can still be drawn.
    NotedPicture picture = shaded_model(subject);
    fmt::print(stderr, "contourctl: warning: the model is drawn as in its file: {}\n",
               printable(error.what()));
    return picture;
  }
}

void refuse_to_overwrite(const JobFiles& files, const PreviewOptions& options) {
  if (!options.output) return;
  std::error_code code;  // ignored: a file that does not exist is not the subject
  if (fs::equivalent(*options.output, files.model, code) ||
      (files.ticket && fs::equivalent(*options.output, *files.ticket, code)))
    throw UsageError(
        fmt::format("-o {}: the output would replace the model or its ticket", options.output->string()));
}

// Tries again if the job is moved meanwhile: it can pass through four folders.
NotedPicture find_and_draw(const ClientOptions& client, const PreviewOptions& options) {
  PreviewSubject subject = subject_of(client, options);
  refuse_to_overwrite(subject.files, options);
  for (int moves = 0;; ++moves) {
    try {
      return draw(subject, options);
    } catch (const ModelError&) {
      constexpr int kMostMoves = 4;
      if (!subject.spooled || is_there(subject.files.model) || moves == kMostMoves) throw;
      subject = job_subject(client, options);
    }
  }
}

int preview(const ClientOptions& client, const PreviewOptions& options) {
  check_picture_output(options.output);
  put_out(find_and_draw(client, options), options.output);
  return kOk;
}

}  // namespace

void add_preview(Command& program) {
  Command& command = program.add("preview", "Draw a model file, or a job in the spool");
  auto& options = command.arguments<PreviewOptions>();
  command.option("JOB", options.subject, "Name of a job, or model file")
      .required()
      .suggests(all_jobs, {model_extensions().begin(), model_extensions().end()});
  command.option("--layer", options.layer, "Draw the mask of this layer, counted from 1")
      .from_to(1, kMaxLayers);
  command.option("--printer", options.printer, kLikePrinterHelp);
  command.option("--ticket", options.ticket, "Ticket for the model file");
  command.option("-o,--output", options.output, kPictureHelp);
  command.option("--spool", options.spool, kSpoolHelp);
  const ClientOptions& client = add_socket_option(command);
  command.run = [&client, &options] { return preview(client, options); };
}

}  // namespace contourd::ctl
