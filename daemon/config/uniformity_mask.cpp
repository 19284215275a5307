#include "daemon/config/uniformity_mask.hpp"

#include <cmath>
#include <stdexcept>
#include <string>
#include <system_error>

#include "daemon/json/profile_file.hpp"
#include "hw/png_file.hpp"

namespace contourd {
namespace {

constexpr const char* kKey = "/display/uniformity_mask";

}  // namespace

std::optional<UniformityMask> load_uniformity_mask(JsonDocument& printer,
                                                   const std::filesystem::path& folder) {
  const auto name = printer.valid_text(kKey);
  if (!name) return std::nullopt;
  const std::filesystem::path file = resolved(folder, *name);
  const auto refuse = [&](const std::string& why) {
    printer.add_violation(kKey, file.string() + ": " + why);
  };
  const auto width = printer.valid_number("/display/width_px"),
             height = printer.valid_number("/display/height_px");
  try {
    Mask mask = read_png(file);
    if (!width || !height || (mask.width().count() == *width && mask.height().count() == *height))
      return UniformityMask{file, std::move(mask)};
    refuse("the picture is " + std::to_string(mask.width().count()) + "x" +
           std::to_string(mask.height().count()) + " pixels, the display " +
           std::to_string(std::llround(*width)) + "x" + std::to_string(std::llround(*height)));
  } catch (const std::system_error& error) {
    refuse(error.code().message());
  } catch (const std::runtime_error& error) {
    refuse(error.what());
  }
  return std::nullopt;
}

}  // namespace contourd
