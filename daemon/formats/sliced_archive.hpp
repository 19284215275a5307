// A sliced archive: a ZIP archive with settings and the finished layers of a print. It is one for printers of
// the type SL1 (.sl1, .sl1s, .sl1_svg), with config.ini and, of each layer, a PNG picture or an SVG file with
// its outlines, as PrusaSlicer writes it; or one for NanoDLP (.nanodlp; see nanodlp_archive.hpp). Used by one
// thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/mask/picture_stack.hpp"
#include "core/mask/pixel_map.hpp"
#include "daemon/formats/sl1_config.hpp"
#include "daemon/formats/zip_archive.hpp"

namespace contourd {

// True if the archive has config.ini and, beside it, files of layers: a name, five digits and .png or .svg;
// or if is_nanodlp() says so.
[[nodiscard]] bool is_sliced(const ZipArchive& archive);

class SlicedArchive {
 public:
  // Reads the settings and the list of layers. Throws ModelError if a setting or a layer is missing or
  // wrong, or a file in the archive exceeds a limit.
  explicit SlicedArchive(std::shared_ptr<const ZipArchive> archive);

  // Returns the name of the format: sl1, sl1_svg or nanodlp.
  [[nodiscard]] const char* format() const { return format_; }
  [[nodiscard]] const SlicedSettings& settings() const { return settings_; }
  [[nodiscard]] std::size_t layers() const { return files_.size(); }
  // True if the layers are SVG outlines (see read_outlines()), false if they are PNG pictures.
  [[nodiscard]] bool has_outlines() const { return has_outlines_; }
  // Returns the layers' files, from the lowest layer up. Valid as long as the archive.
  [[nodiscard]] std::span<const ZipEntry* const> layer_files() const { return files_; }
  // Opens a file. Throws what ZipArchive::open() throws.
  [[nodiscard]] std::unique_ptr<ByteStream> open(const ZipEntry& entry) const {
    return archive_->open(entry);
  }

  // Returns the pictures as this display is sent them, so that the light on the plate is that of the sliced
  // model, seen from above: the slicer's mirrors and its quarter turn are undone, and the display's own ones
  // applied. If the file does not tell them, the pictures are as they are. A display with the sides exchanged
  // gets them turned by a quarter. Blocks, for 10 to 50 ms a layer and 4 million pixels. Throws ModelError if
  // size or pitch of the pixels do not agree with the display, if a picture is damaged or no 8-bit grey PNG
  // of the first one's size, if all are dark, or if the stack needs more than `most_bytes` of memory. Returns
  // a part of the stack if a stop was requested. REQUIRES: the archive has pictures.
  [[nodiscard]] std::shared_ptr<const PictureStack> read(const DisplayGeometry& display,
                                                         std::uint64_t most_bytes,
                                                         const std::stop_token& stop) const;

 private:
  void list_layers();
  [[nodiscard]] std::vector<std::uint8_t> bytes_of(const ZipEntry& entry, std::uint64_t most) const;

  std::shared_ptr<const ZipArchive> archive_;
  SlicedSettings settings_;
  std::vector<const ZipEntry*> files_;  // by layer
  bool has_outlines_ = false;
  const char* format_ = "sl1";
};

}  // namespace contourd
