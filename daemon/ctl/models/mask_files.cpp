#include "daemon/ctl/models/mask_files.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/ctl/models/layer_folder.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

void encode_mask(const std::filesystem::path& path, const Mask& mask, MaskPngEncoder& encoder) {
  try {
    write_png(path, mask, encoder);
  } catch (const std::system_error& error) {
    throw OutputError(error.what());
  }
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

void write_mask(const std::filesystem::path& path, const Mask& mask) {
  MaskPngEncoder encoder;
  encode_mask(path, mask, encoder);
}

std::vector<LayerCracks> write_masks(const std::filesystem::path& folder, std::span<const Nanometers> layers,
                                     const std::function<ContourEngine()>& make_engine) {
  LayerQueue queue(layers.size());
  std::vector<LayerCracks> cracks(layers.size());  // each element is written by the thread that has the layer
  const auto write_some = [&] {
    std::optional<ContourEngine> engine;
    MaskPngEncoder encoder;
    queue.serve([&](std::size_t layer) {
      if (!engine) engine.emplace(make_engine());
      encode_mask(folder / layer_file(layer + 1, ".png"), engine->mask_at(layers[layer]), encoder);
      cracks[layer] = engine->cracks();
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

}  // namespace contourd::ctl
