#include "daemon/ctl/models/layer_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "core/image/mask_png.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

void encode_mask(const fs::path& path, const Mask& mask, MaskPngEncoder& encoder) {
  try {
    write_png(path, mask, encoder);
  } catch (const std::system_error& error) {
    throw OutputError(error.what());
  }
}

// True if layer_file() returns this name for some layer.
bool is_layer_file(const fs::path& path, std::string_view extension) {
  const std::string stem = path.stem().string();
  return path.extension() == extension && stem.size() >= 4 &&
         std::ranges::all_of(stem, [](char c) { return c >= '0' && c <= '9'; }) &&
         (stem.size() == 4 || stem.front() != '0');
}

std::vector<fs::path> layer_files_in(const fs::path& folder, std::string_view extension) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    // A folder with such a name is not a layer's file.
    if (is_layer_file(entry.path(), extension) && entry.symlink_status().type() != fs::file_type::directory)
      files.push_back(entry.path());
  }
  // Sorted by number: shorter names first.
  std::ranges::sort(files, {},
                    [](const fs::path& path) { return std::pair(path.native().size(), path.native()); });
  return files;
}

// Distributes the layers to threads, from the first to the last or to the first that failed. Thread-safe.
class LayerQueue {
 public:
  explicit LayerQueue(std::size_t layers) : end_(layers) {}

  // Calls work(layer) for layers that no other thread has, until none is left.
  template <typename Work>
  void serve(Work&& work) {
    for (std::size_t layer = next_++; layer < end_; layer = next_++) {
      try {
        work(layer);
      } catch (...) {
        fail(layer, std::current_exception());
      }
    }
  }

  // Throws the exception of the lowest failed layer, if a layer failed.
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void fail(std::size_t layer, std::exception_ptr failure) {
    const std::lock_guard lock(failing_);
    if (layer >= end_) return;
    end_ = layer;  // lower layers are still tried, so that the lowest failure is reported
    failure_ = std::move(failure);
  }

  std::atomic<std::size_t> next_ = 0, end_;
  std::mutex failing_;
  std::exception_ptr failure_;
};

}  // namespace

void write_text(const fs::path& path, std::string_view text) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file) throw OutputError(fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
}

void write_mask(const fs::path& path, const Mask& mask) {
  MaskPngEncoder encoder;
  encode_mask(path, mask, encoder);
}

std::string layer_file(std::size_t layer, std::string_view extension) {
  return fmt::format("{:04}{}", layer, extension);
}

void open_layer_folder(const fs::path& folder, std::string_view extension, Earlier earlier) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) throw OutputError(fmt::format("cannot make the folder {}: {}", folder.string(), code.message()));
  try {
    const std::vector<fs::path> files = layer_files_in(folder, extension);
    if (files.empty()) return;
    if (earlier == Earlier::Refuse) {
      throw OutputError(fmt::format("{} contains {} of an earlier slice, {} to {}; --force replaces them",
                                    folder.string(),
                                    files.size() == 1 ? "a file" : fmt::format("{} files", files.size()),
                                    files.front().filename().string(), files.back().filename().string()));
    }
    for (const fs::path& file : files)
      fs::remove(file);
  } catch (const fs::filesystem_error& error) {
    throw OutputError(fmt::format("cannot replace the files of an earlier slice in {}: {}", folder.string(),
                                  error.code().message()));
  }
}

std::vector<LayerCracks> write_masks(const fs::path& folder, std::span<const Nanometers> layers,
                                     const std::function<MaskMaker()>& make_maker) {
  LayerQueue queue(layers.size());
  std::vector<LayerCracks> cracks(layers.size());  // each element is written by the thread that has the layer
  const auto write_some = [&] {
    std::optional<MaskMaker> maker;
    MaskPngEncoder encoder;
    queue.serve([&](std::size_t layer) {
      if (!maker) maker.emplace(make_maker());
      const Mask* mask = &maker->engine.mask_at(layers[layer]);
      if (maker->undersides) mask = &maker->undersides->mask(layer, maker->engine.coverage());
      if (maker->given) mask = &maker->given->of(layer, *mask);
      encode_mask(folder / layer_file(layer + 1, ".png"), *mask, encoder);
      cracks[layer] = maker->engine.cracks();
    });
  };
  {
    std::vector<std::jthread> others;
    const std::size_t threads = std::min<std::size_t>(std::thread::hardware_concurrency(), layers.size());
    while (others.size() + 1 < threads)
      others.emplace_back(write_some);
    write_some();
  }
  queue.rethrow();
  return cracks;
}

void write_contours(const fs::path& path, const Contours& contours, const PixelMap& map) {
  std::string csv = "loop,x_mm,y_mm,x_pixel,y_pixel\n";
  for (std::size_t loop = 0; loop < contours.loops.size(); ++loop) {
    for (const Point& point : contours.points_of(contours.loops[loop])) {
      const PixelPoint pixel = map.to_pixels(point);
      csv += fmt::format("{},{:.6f},{:.6f},{:.3f},{:.3f}\n", loop + 1, point.x, point.y, pixel.x, pixel.y);
    }
  }
  write_text(path, csv);
}

}  // namespace contourd::ctl
