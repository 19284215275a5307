#include "daemon/ctl/terminal/picture_output.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <string_view>
#include <system_error>
#include <vector>

#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/ctl/terminal/terminal_picture.hpp"
#include "daemon/ctl/terminal/text_columns.hpp"
#include "daemon/json/profile_file.hpp"
#include "daemon/system/durable_file.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStandardOutput = "-";

bool is_there(const fs::path& path) {
  std::error_code code;
  return fs::exists(fs::symlink_status(path, code));
}

// Returns the target of a link, so that the target is replaced and not the link.
fs::path target_of(const fs::path& output) {
  std::error_code code;
  return fs::is_symlink(output, code) ? fs::canonical(output, code) : output;
}

void write_png_file(const fs::path& output, std::string_view png) {
  const fs::path target = target_of(output);
  // Holds signals back until the file is complete: without O_TMPFILE, an interruption would leave a temporary
  // file.
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
    (void)std::fwrite(png.data(), 1, png.size(), stdout);  // errors are reported when stdout is closed
  } else {
    write_png_file(output, png);
  }
}

std::string pixels_text(const Mask& mask, const MaskArea& area) {
  const std::string all = fmt::format("{}x{} pixels", mask.width().count(), mask.height().count());
  if (area == whole_of(mask)) return fmt::format("all {}", all);
  return fmt::format("columns {} to {} and rows {} to {} of {}; the others are dark", area.left + 1,
                     area.left + area.width, area.top + 1, area.top + area.height, all);
}

void draw_on_terminal(const NotedPicture& picture) {
  if (picture.mask.lit_pixels() == 0) {
    fmt::print("{}\n{}\n", picture.note, picture.is_mask ? "nothing is lit" : "nothing is visible");
    return;
  }
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

}  // namespace

void check_picture_output(const std::optional<fs::path>& wanted) {
  if (!wanted) return;
  const fs::path& output = *wanted;
  if (output == kStandardOutput) {
    if (::isatty(STDOUT_FILENO) != 0)
      throw UsageError("-o -: standard output is a terminal; without -o the picture is drawn there");
    return;
  }
  std::error_code code;
  const fs::path target = target_of(output);
  if (target.empty())
    throw OutputError(fmt::format("cannot write {}: it is a dangling link", output.string()));
  if (is_there(target) && !fs::is_regular_file(target, code))
    throw OutputError(fmt::format("cannot write {}: it exists and is not a regular file", output.string()));
}

void put_out(const NotedPicture& picture, const std::optional<fs::path>& output) {
  if (output)
    write_picture(*output, picture.mask);
  else
    draw_on_terminal(picture);
}

}  // namespace contourd::ctl
