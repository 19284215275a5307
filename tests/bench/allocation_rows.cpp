// Replaces this program's operator new by one that counts.
#include <fmt/format.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

#include "tests/bench/bench.hpp"

namespace {

std::atomic<long> allocations = 0;

void* counted(std::size_t bytes) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (void* memory = std::malloc(bytes != 0 ? bytes : 1)) return memory;
  throw std::bad_alloc();
}

void* counted(std::size_t bytes, std::align_val_t alignment) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  const auto align = static_cast<std::size_t>(alignment);
  const std::size_t rounded = (bytes + align - 1) / align * align;
  if (void* memory = std::aligned_alloc(align, rounded != 0 ? rounded : align)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t bytes) {
  return counted(bytes);
}
void* operator new[](std::size_t bytes) {
  return counted(bytes);
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return counted(bytes, alignment);
}
void* operator new[](std::size_t bytes, std::align_val_t alignment) {
  return counted(bytes, alignment);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace contourd::bench {
namespace {

Row row_of(const Bench& bench, const std::string& model, const std::filesystem::path& file) {
  ContourEngine engine = fitted_engine(file, Pixels{1920}, Pixels{1080});
  const std::vector<Millimeters> heights = random_heights(engine.model().bounds(), bench.runs(300));
  long counted = 0;
  for (int pass = 0; pass < 2; ++pass) {  // warm in the second
    const long before = allocations;
    for (const Millimeters z : heights)
      (void)engine.mask_at_z(z);
    counted = allocations - before;
  }
  Row row{"allocations-" + model, model + ", allocations a mask, warm", ""};
  row.figure = static_cast<double>(counted) / static_cast<double>(heights.size());
  row.target = Target{Target::Kind::AtMost, 0};
  return row;
}

}  // namespace

std::vector<Row> allocation_rows(const Bench& bench) {
  const auto plate = bench.models.shared(kPlate);
  return {plate ? row_of(bench, "plate", *plate) : skipped_rows({"allocations-plate"}, kPlate).front(),
          row_of(bench, "gyroid", bench.models.gyroid())};
}

}  // namespace contourd::bench
