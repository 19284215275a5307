#include "daemon/ctl/models/sl1_file.hpp"

#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <functional>
#include <list>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/image/thumbnail.hpp"
#include "core/layers/layers.hpp"
#include "daemon/ctl/models/slicer_settings.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/report/job_picture.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

using Bytes = std::vector<std::uint8_t>;

// A file of an archive, whose bytes are made once, when its turn to be written comes, and freed after that.
class LazyEntry {
 public:
  explicit LazyEntry(std::function<Bytes()> make) : make_(std::move(make)) {}

  // The exception of make(): it must not pass through the library, which is C.
  [[nodiscard]] const std::exception_ptr& failure() const { return failure_; }

  static zip_int64_t handle(void* self, void* data, zip_uint64_t length, zip_source_cmd_t command) {
    return static_cast<LazyEntry*>(self)->answer(data, length, command);
  }

 private:
  zip_int64_t answer(void* data, zip_uint64_t length, zip_source_cmd_t command) {
    switch (command) {
      case ZIP_SOURCE_SUPPORTS:
        return zip_source_make_command_bitmap(ZIP_SOURCE_OPEN, ZIP_SOURCE_READ, ZIP_SOURCE_CLOSE,
                                              ZIP_SOURCE_STAT, ZIP_SOURCE_ERROR, ZIP_SOURCE_FREE, -1);
      case ZIP_SOURCE_STAT:
        return tell_size(*static_cast<zip_stat_t*>(data));
      case ZIP_SOURCE_OPEN:
        given_ = 0;
        return make_once() ? 0 : -1;
      case ZIP_SOURCE_READ:
        return give(data, length);
      case ZIP_SOURCE_CLOSE:
        Bytes().swap(bytes_);
        return 0;
      case ZIP_SOURCE_ERROR: {
        zip_error_t error{};
        zip_error_init(&error);
        zip_error_set(&error, ZIP_ER_INTERNAL, 0);
        return zip_error_to_data(&error, data, length);
      }
      case ZIP_SOURCE_FREE:
        return 0;
      default:
        return -1;
    }
  }

  // The library asks for the size before it reads the bytes, and again after that.
  zip_int64_t tell_size(zip_stat_t& status) {
    if (!make_once()) return -1;
    zip_stat_init(&status);
    status.valid = ZIP_STAT_SIZE;
    status.size = *size_;
    return sizeof status;
  }

  zip_int64_t give(void* to, zip_uint64_t length) {
    const std::size_t bytes = std::min<std::size_t>(length, bytes_.size() - given_);
    std::memcpy(to, bytes_.data() + given_, bytes);
    given_ += bytes;
    return static_cast<zip_int64_t>(bytes);
  }

  // Makes the bytes unless that was done or failed before. False if it failed.
  [[nodiscard]] bool make_once() {
    if (size_ || failure_) return !failure_;
    try {
      bytes_ = make_();
      size_ = bytes_.size();
    } catch (...) {
      failure_ = std::current_exception();
    }
    return !failure_;
  }

  std::function<Bytes()> make_;
  Bytes bytes_;
  std::optional<std::size_t> size_;  // nullopt: not made yet
  std::size_t given_ = 0;
  std::exception_ptr failure_;
};

// A ZIP archive that is written when it is closed, into a file of another name first.
class ZipFile {
 public:
  explicit ZipFile(const fs::path& path) : path_(path) {
    std::error_code error;
    if (fs::exists(path, error) && !fs::is_regular_file(path, error)) fail("not a regular file");
    int code = 0;
    archive_.reset(zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code));
    if (archive_) return;
    zip_error_t problem{};
    zip_error_init_with_code(&problem, code);
    const std::string why = zip_error_strerror(&problem);
    zip_error_fini(&problem);
    fail(why);
  }

  enum class Packing { Stored, Deflated };
  void add(const std::string& name, Packing packing, std::function<Bytes()> make) {
    LazyEntry& entry = entries_.emplace_back(std::move(make));
    zip_source_t* const source = zip_source_function(archive_.get(), LazyEntry::handle, &entry);
    const zip_int64_t index =
        source == nullptr ? -1 : zip_file_add(archive_.get(), name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
      zip_source_free(source);
      fail(zip_strerror(archive_.get()));
    }
    if (packing == Packing::Stored)
      zip_set_file_compression(archive_.get(), static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0);
  }

  // Makes the files' bytes one after another, and writes the archive.
  void write() {
    if (zip_close(archive_.get()) == 0) {
      (void)archive_.release();
      return;
    }
    for (const LazyEntry& entry : entries_)
      if (entry.failure()) std::rethrow_exception(entry.failure());
    fail(zip_strerror(archive_.get()));
  }

 private:
  struct Discard {
    void operator()(zip_t* archive) const { zip_discard(archive); }
  };

  [[noreturn]] void fail(const std::string& why) const {
    throw OutputError(fmt::format("cannot write {}: {}", path_.string(), why));
  }

  fs::path path_;
  std::list<LazyEntry> entries_;  // freed after the archive
  std::unique_ptr<zip_t, Discard> archive_;
};

Bytes bytes_of_text(const std::string& text) {
  return {text.begin(), text.end()};
}

// Returns the model's name with characters only that are safe in names of files and in INI files.
std::string archive_name(const fs::path& model) {
  std::string name = model.stem().string();
  std::ranges::replace_if(
      name,
      [](char c) {
        return !((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
                 c == '.');
      },
      '_');
  return name;
}

// Returns the picture in the middle of one of this size.
Mask centered(const Mask& picture, Pixels width, Pixels height) {
  const Mask small = make_thumbnail(picture, {0, 0, picture.width().count(), picture.height().count()},
                                    std::min(width, height));
  Mask made(width, height);
  const std::int32_t left = (width - small.width()).count() / 2, top = (height - small.height()).count() / 2;
  for (std::int32_t y = 0; y < small.height().count(); ++y)
    std::ranges::copy(small.row(y), made.row(top + y).begin() + left);
  return made;
}

// The layers of a print, drawn one after another.
class SlicedPrint {
 public:
  SlicedPrint(const PrintSubject& subject, std::string name)
      : subject_(subject), name_(std::move(name)), undersides_(subject.dimmed_masks()) {}

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<LayerCracks>& cracks() const { return cracks_; }

  // Draws the next layer.
  Bytes next_picture() {
    const std::size_t layer = cracks_.size();
    ContourEngine& engine = *subject_.engine;
    (void)engine.mask_at(middles_[layer]);
    const Mask* light = &engine.coverage();
    if (undersides_) {
      (void)undersides_->mask(layer, *light);
      light = &undersides_->light();
    }
    lit_pixels_ += light->lit_area();
    cracks_.push_back(engine.cracks());
    const auto bytes = encoder_.encode(*light);
    return {bytes.begin(), bytes.end()};
  }

  // Returns the text of config.ini. REQUIRES: all layers are drawn.
  [[nodiscard]] std::string config() const {
    expects(cracks_.size() == subject_.layers.size(), "all layers are drawn");
    const ResinProfile& resin = subject_.resin.value();
    const double pitch_mm = to_millimeters(subject_.settings.display.pixel_pitch).count();
    const double volume_ml = lit_pixels_ * pitch_mm * pitch_mm * in_mm(subject_.layers.front()) / 1000;
    const auto time =
        std::accumulate(subject_.layer_durations->begin(), subject_.layer_durations->end(), Duration{});
    const SlicerLayers layers = slicer_layers();
    return ini_text({{"action", "print"},
                     {"expTime", slicer_seconds(layers.exposure)},
                     {"expTimeFirst", slicer_seconds(layers.first_exposure)},
                     {"expUserProfile", "0"},
                     {"hollow", "0"},
                     {"jobDir", name_},
                     {"layerHeight", slicer_mm(layers.height)},
                     {"materialName", archive_name(resin.name)},
                     {"numFade", std::to_string(layers.fading_layers)},
                     {"numFast", std::to_string(subject_.layers.size())},
                     {"numSlow", "0"},
                     {"printProfile", "contourd"},
                     {"printTime", fmt::format("{:.0f}", std::chrono::duration<double>(time).count())},
                     {"printerModel", "contourd"},
                     {"printerProfile", "contourd"},
                     {"printerVariant", "default"},
                     {"usedMaterial", fmt::format("{:.6f}", volume_ml)}});
  }

  // Returns the text of prusaslicer.ini.
  [[nodiscard]] std::string slicer_config() const {
    SlicerSettings settings = display_settings(subject_.settings.display);
    for (auto& setting : layer_settings(slicer_layers()))
      settings.push_back(std::move(setting));
    settings.insert(settings.end(), {{"gamma_correction", "1"}, {"printer_technology", "SLA"}});
    std::ranges::sort(settings);
    return ini_text(settings);
  }

 private:
  [[nodiscard]] SlicerLayers slicer_layers() const {
    const LayerExposures& exposures = subject_.exposures.value();
    return {subject_.layers.front(), exposures.normal, exposures.first, subject_.resin.value().fade_layers};
  }

  const PrintSubject& subject_;
  std::string name_;
  std::unique_ptr<DimmedMasks> undersides_;
  std::vector<Nanometers> middles_ = middles_of(subject_.layers);
  std::vector<LayerCracks> cracks_;  // of the layers drawn so far
  double lit_pixels_ = 0;
  MaskPngEncoder encoder_;
};

}  // namespace

std::vector<LayerCracks> write_sl1(const fs::path& path, const fs::path& model, const PrintSubject& subject) {
  expects(!subject.layers.empty() && subject.exposures,
          "the print has a printer's configuration and a layer");
  constexpr std::size_t kMostLayers = 99'999;  // five digits
  if (std::ranges::any_of(subject.layers, [&](Nanometers layer) { return layer != subject.layers.front(); }))
    throw UsageError("--sl1 needs layers of one thickness: leave out adaptive_layers");
  if (subject.layers.size() > kMostLayers)
    throw UsageError(fmt::format("--sl1 is for at most {} layers, and the print has {}", kMostLayers,
                                 subject.layers.size()));
  SlicedPrint print(subject, archive_name(model));
  ZipFile archive(path);
  using Packing = ZipFile::Packing;
  for (std::size_t layer = 0; layer < subject.layers.size(); ++layer)
    archive.add(fmt::format("{}{:05}.png", print.name(), layer), Packing::Stored,
                [&print] { return print.next_picture(); });
  const Mask preview = draw_job(*subject.engine, subject.supports ? &*subject.supports : nullptr).picture;
  archive.add("thumbnail/thumbnail400x400.png", Packing::Stored,
              [&preview] { return encode_png(centered(preview, Pixels{400}, Pixels{400})); });
  archive.add("thumbnail/thumbnail800x480.png", Packing::Stored,
              [&preview] { return encode_png(centered(preview, Pixels{800}, Pixels{480})); });
  archive.add("prusaslicer.ini", Packing::Deflated,
              [&print] { return bytes_of_text(print.slicer_config()); });
  archive.add("config.ini", Packing::Deflated, [&print] { return bytes_of_text(print.config()); });
  archive.write();
  return print.cracks();
}

}  // namespace contourd::ctl
