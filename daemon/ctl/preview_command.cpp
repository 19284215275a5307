#include "daemon/ctl/preview_command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/image/preview.hpp"
#include "daemon/config/config_error.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/config/profile_file.hpp"
#include "daemon/control_defaults.hpp"
#include "daemon/ctl/exit_codes.hpp"
#include "daemon/ctl/read_model.hpp"
#include "daemon/ctl/spooled_job.hpp"
#include "daemon/ctl/statistics_text.hpp"
#include "daemon/ctl/terminal.hpp"
#include "daemon/ctl/terminal_picture.hpp"
#include "daemon/ctl/text_columns.hpp"
#include "daemon/job_content.hpp"
#include "daemon/job_picture.hpp"
#include "daemon/memory_room.hpp"
#include "daemon/new_file.hpp"
#include "daemon/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStandardOutput = "-";

struct Subject {
  JobFiles files;
  std::string title;  // printable
  bool spooled = false;
};

struct Picture {
  Mask mask;
  std::string note;      // what it shows; printable
  bool is_mask = false;  // whose every pixel counts; else a picture for people
};

// --- what is to be shown

bool is_there(const fs::path& path) {
  std::error_code code;
  return fs::exists(fs::symlink_status(path, code));
}

Subject file_subject(const PreviewOptions& options) {
  const fs::path path = options.subject;
  look_at_model(path);  // what cannot be read is told as by the other commands
  return {{path.stem().string(), path, options.ticket}, printable(path.filename().string())};
}

std::string elsewhere(const SpooledJob& job) {
  std::string folders;
  for (const SpoolFolder folder : job.others)
    folders += fmt::format("{}{}", folders.empty() ? "" : " and in ", name_of(folder));
  return folders.empty() ? "" : fmt::format(" (there is another in {})", folders);
}

Subject job_subject(const ClientOptions& client, const PreviewOptions& options) {
  const SpoolFolders spool = [&] {
    try {
      return SpoolFolders(find_spool(client, options.spool));
    } catch (const DaemonError& error) {
      throw DaemonError(
          fmt::format("there is no file {}, and whether a job is called so is not known: {}; --spool names "
                      "the folder of the jobs",
                      in_quotes(options.subject), error.what()));
    }
  }();
  const std::optional<SpooledJob> job = find_job(spool, options.subject);
  if (!job) {
    throw std::system_error(std::make_error_code(std::errc::no_such_file_or_directory),
                            fmt::format("neither a file nor a job in {} is called {}", spool.root().string(),
                                        in_quotes(options.subject)));
  }
  if (options.ticket) throw UsageError("--ticket goes with a file: a job has its own");
  return {job->files,
          fmt::format("{}, in {}{}", printable(job->files.name), name_of(job->folder), elsewhere(*job)),
          true};
}

// A word with a slash, or that a file of this folder is called, is that file.
bool is_file(const std::string& subject) {
  std::error_code code;
  return subject.find('/') != std::string::npos || (is_there(subject) && !fs::is_directory(subject, code));
}

Subject subject_of(const ClientOptions& client, const PreviewOptions& options) {
  return is_file(options.subject) ? file_subject(options) : job_subject(client, options);
}

// --- its picture

PrinterConfig printer_for(const PreviewOptions& options, std::string_view what) {
  const fs::path file = options.printer.value_or(kDefaultConfig);
  if (!options.printer && !is_there(file)) {
    throw UsageError(fmt::format(
        "{} needs a printer's configuration: there is no {}, --printer names another", what, file.string()));
  }
  return load_printer_config(file, Places::Elsewhere);
}

Picture mask_of_layer(const Subject& subject, PreparedJob job, int number) {
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
      fmt::format("{}: layer {} of {}, {:.3f} to {:.3f} mm, {:.2f} mm2", subject.title, number, layers.size(),
                  to_millimeters(bottom).count(), to_millimeters(bottom + layers[index]).count(), mm2),
      true};
}

std::string size_text(double x, double y, double z) {
  return fmt::format("{:.6g} x {:.6g} x {:.6g} mm", x, y, z);
}

Picture shaded_job(const Subject& subject, const PreparedJob& job) {
  const JobSummary& summary = job.summary;
  std::size_t parts = 0;
  for (const ModelSummary& model : summary.models)
    parts += model.centers.size();
  const ModelSummary& first = summary.models.front();
  const std::string what = summary.plate
                               ? fmt::format("{} models, {:.6g} mm high", parts, summary.height_mm)
                               : fmt::format("{}{}", parts > 1 ? fmt::format("{} of ", parts) : "",
                                             size_text(first.size_x_mm, first.size_y_mm, first.size_z_mm));
  const Millimeters top{std::numeric_limits<double>::infinity()};
  return {draw_job_picture(summary, *job.plan.engine, top, DrawnCopies::All),
          fmt::format("{}: {}, layers {}", subject.title, what, layers_text(job.plan.expected_layers))};
}

std::vector<Facet> facets_of(const Subject& subject) {
  const JobFiles& files = subject.files;
  if (!subject.spooled) return read_model(files.model).facets;
  try {
    JobContent content(files.model, files.plate, files.links, JobTicket{});
    content.read(DisplayGeometry{}, memory_room(std::nullopt));
    return content.take_facets(0);
  } catch (const JobRefused& refusal) {
    throw ModelError(files.model.string() + ": " + refusal.what());
  }
}

Picture shaded_model(const Subject& subject) {
  const std::vector<Facet> facets = facets_of(subject);
  const Bounds bounds = bounds_of(facets);
  const Millimeters top{std::numeric_limits<double>::infinity()};
  return {render_preview(facets, top, kJobPictureSide, kJobPictureSide),
          fmt::format("{}: {}, {} facets", subject.title,
                      size_text(bounds.size_x(), bounds.size_y(), bounds.size_z()), facets.size())};
}

Picture draw(const Subject& subject, const PreviewOptions& options) {
  const JobFiles& files = subject.files;
  if (options.layer)
    return mask_of_layer(subject, prepare_model(files, printer_for(options, "--layer")), *options.layer);
  if (!options.printer && !files.ticket && !files.plate) return shaded_model(subject);
  const PrinterConfig printer = printer_for(options, files.plate ? "a plate" : "a ticket");
  try {
    return shaded_job(subject, prepare_model(files, printer));
  } catch (const ModelError& error) {
    if (!subject.spooled || files.plate) throw;
    // A job that cannot be printed can be looked at.
    Picture picture = shaded_model(subject);
    fmt::print(stderr, "contourctl: warning: shown as its file has it: {}\n", printable(error.what()));
    return picture;
  }
}

// --- where it goes

// The file that a link leads to is written, not the link.
fs::path target_of(const fs::path& output) {
  std::error_code code;
  return fs::is_symlink(output, code) ? fs::canonical(output, code) : output;
}

// Whatever shows before the model is read.
void check_output(const PreviewOptions& options) {
  const fs::path output = options.output.value_or("");
  if (output.empty()) return;
  if (output == kStandardOutput) {
    if (::isatty(STDOUT_FILENO) != 0)
      throw UsageError("-o -: standard output is a terminal; without -o the picture is drawn there");
    return;
  }
  std::error_code code;
  const fs::path target = target_of(output);
  if (target.empty())
    throw OutputError(fmt::format("cannot write {}: it is a link that leads nowhere", output.string()));
  if (is_there(target) && !fs::is_regular_file(target, code))
    throw OutputError(fmt::format("cannot write {}: it is there, and no regular file", output.string()));
}

void refuse_to_overwrite(const JobFiles& files, const PreviewOptions& options) {
  if (!options.output) return;
  std::error_code code;  // of what is not there
  if (fs::equivalent(*options.output, files.model, code) ||
      (files.ticket && fs::equivalent(*options.output, *files.ticket, code)))
    throw UsageError(fmt::format("-o {}: that is the file that is to be shown", options.output->string()));
}

void write_png_file(const fs::path& output, std::string_view png) {
  const fs::path target = target_of(output);
  // Nothing is left behind by whoever interrupts it, where files without a name are not to be had.
  const HeldSignals signals;
  try {
    NewFile file(folder_of(target));
    file.write(png);
    file.replace(target.filename().string());
  } catch (const std::system_error& error) {
    throw OutputError(fmt::format("cannot write {}: {}", output.string(), error.code().message()));
  }
}

void write_picture(const fs::path& output, const Mask& mask) {
  const std::vector<std::uint8_t> bytes = encode_png(mask);
  const std::string_view png(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (output == kStandardOutput) {
    (void)std::fwrite(png.data(), 1, png.size(), stdout);  // what is lost is told at the end
  } else {
    write_png_file(output, png);
  }
}

std::string pixels_text(const Mask& mask, const MaskArea& area) {
  const std::string all = fmt::format("{}x{} pixels", mask.width().count(), mask.height().count());
  if (mask.lit_pixels() == 0) return fmt::format("nothing is lit of {}", all);
  if (area == whole_of(mask)) return fmt::format("all {}", all);
  return fmt::format("columns {} to {} and rows {} to {} of {}; the others are dark", area.left + 1,
                     area.left + area.width, area.top + 1, area.top + area.height, all);
}

void draw_on_terminal(const Picture& picture) {
  PictureTerminal terminal = find_picture_terminal();
  const MaskArea area = picture.is_mask ? area_to_show(picture.mask, terminal) : lit_area(picture.mask);
  std::vector<std::string> lines = wrapped(picture.note, static_cast<std::size_t>(terminal.columns));
  if (picture.is_mask || picture.mask.lit_pixels() == 0) {
    const auto more = wrapped(pixels_text(picture.mask, area), static_cast<std::size_t>(terminal.columns));
    lines.insert(lines.end(), more.begin(), more.end());
  }
  for (const std::string& line : lines)
    fmt::print("{}\n", line);
  leave_lines(terminal, lines.size());
  print_picture(draw_picture(picture.mask, area, terminal));
}

// A job may be moved while it is looked for: from one folder to the next, and there are four.
Picture find_and_draw(const ClientOptions& client, const PreviewOptions& options) {
  Subject subject = subject_of(client, options);
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

}  // namespace

int preview(const ClientOptions& client, const PreviewOptions& options) {
  check_output(options);
  const Picture picture = find_and_draw(client, options);
  if (options.output) {
    write_picture(*options.output, picture.mask);
  } else {
    draw_on_terminal(picture);
  }
  return kOk;
}

}  // namespace contourd::ctl
