#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "core/model/model.hpp"
#include "daemon/ctl/models/model_commands.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/frames/frame_file.hpp"
#include "daemon/frames/frame_summary.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd::ctl {
namespace {

struct FramesOptions {
  std::filesystem::path file;
  bool json = false, csv = false;
};

double um(Nanometers length) {
  return in_mm(length) * 1000;
}

FrameFile read_frames(const std::filesystem::path& path) {
  try {
    FrameFile file = read_frame_file(path);
    if (file.records.empty() && !file.complete)
      throw std::runtime_error("its first block is damaged or cut short");
    return file;
  } catch (const UnreadableFile& error) {
    throw UnreadableFile(error.code(),
                         fmt::format("cannot read {}: {}", printable(path.string()), error.what()));
  } catch (const std::runtime_error& error) {
    throw ModelError(fmt::format("{}: {}; give the NAME.frames.bin of a continuous print",
                                 printable(path.string()), error.what()));
  }
}

std::string record_text(const FrameFile& file) {
  if (file.after_end > 0)
    return fmt::format("damaged: {} after its end", count_of(file.after_end, "byte", "bytes"));
  if (!file.complete) return "ends early: masks shown after these are not known";
  if (file.lost > 0) return fmt::format("{} masks are missing", file.lost);
  return "complete";
}

void print_summary(const FrameFile& file, const FrameSummary& all) {
  fmt::print("masks         {} in {}, plate from {:.3f} to {:.3f} mm\n", all.masks,
             count_of(all.rises, "rise", "rises"), in_mm(all.lowest), in_mm(all.highest));
  fmt::print("light         {}\n", readable(all.lit));
  fmt::print("missed        {} of {} showed an older mask\n", all.missed,
             count_of(all.refreshes, "refresh", "refreshes"));
  fmt::print("cuts          {:.2f} um (at {:.3f} mm) to {:.2f} um (at {:.3f} mm) below the plate\n",
             um(all.nearest.way), in_mm(all.nearest.at), um(all.farthest.way), in_mm(all.farthest.at));
  fmt::print("while shown   the plate rose at most {:.2f} um, to {:.3f} mm\n", um(all.longest.way),
             in_mm(all.longest.at));
  fmt::print("record        {}\n", record_text(file));
}

void print_summary_json(const FrameFile& file, const FrameSummary& all) {
  const nlohmann::ordered_json json{{"masks", all.masks},
                                    {"rises", all.rises},
                                    {"lowest_mm", in_mm(all.lowest)},
                                    {"highest_mm", in_mm(all.highest)},
                                    {"lit_s", in_seconds(all.lit)},
                                    {"refreshes", all.refreshes},
                                    {"missed", all.missed},
                                    {"below_plate_um", {um(all.nearest.way), um(all.farthest.way)}},
                                    {"risen_um", um(all.longest.way)},
                                    {"lost", file.lost},
                                    {"complete", file.complete}};
  fmt::print("{}\n", json.dump(2));
}

void print_table(const FrameFile& file) {
  fmt::print("layer,begins,shown_s,cut_mm,first_mm,last_mm,lit_ms,refreshes,missed,light_percent\n");
  for (const FrameRecord& each : file.records)
    fmt::print("{},{},{:.6f},{:.6f},{:.6f},{:.6f},{:.3f},{},{},{:.1f}\n", each.layer + 1, each.begins ? 1 : 0,
               in_seconds(each.shown.time_since_epoch()), in_mm(each.cut), in_mm(each.first),
               in_mm(each.last), in_ms(each.lit), each.refreshes, each.missed, each.light / 2.55);
}

int frames(const FramesOptions& options) {
  const FrameFile file = read_frames(options.file);
  if (options.csv) {
    print_table(file);
  } else if (options.json) {
    print_summary_json(file, summary_of(file.records));
  } else {
    print_summary(file, summary_of(file.records));
  }
  return kOk;
}

}  // namespace

void add_frames(Command& program) {
  Command& command = program.add("frames", "Show the masks that a continuous print has shown");
  auto& options = command.arguments<FramesOptions>();
  command.option("FILE", options.file, "NAME.frames.bin of a finished print").required();
  const Option& json = command.option("--json", options.json, "Print JSON");
  command.option("--csv", options.csv, "Print a line for each mask").excludes(json);
  command.run = [&options] { return frames(options); };
}

}  // namespace contourd::ctl
