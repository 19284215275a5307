// The context of the benchmark's measurements, and the list of them. Each measurement returns its rows.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "tests/bench/report.hpp"

namespace contourd::bench {

// The models' files. Generated models are made on first use and kept in `folder`. Not thread-safe.
class Models {
 public:
  Models(std::filesystem::path folder, std::filesystem::path shared, bool quick)
      : folder_(std::move(folder)), shared_(std::move(shared)), quick_(quick) {}

  // Returns a model that the project cannot generate; nullopt if its file is not available.
  [[nodiscard]] std::optional<std::filesystem::path> shared(const std::string& name) const;
  // Returns a binary file of 1.3 million facets (2,400 for a quick run). Throws std::runtime_error if it
  // cannot be written.
  [[nodiscard]] std::filesystem::path gyroid() const;
  // Returns an ASCII file of the same shape with 294,000 facets (2,400 for a quick run). Throws as gyroid()
  // does.
  [[nodiscard]] std::filesystem::path ascii_gyroid() const;

 private:
  std::filesystem::path folder_, shared_;
  bool quick_;
};

struct Bench {
  bool quick = false;  // only checks that everything works; the figures mean nothing
  bool peers = true;   // also run other programs
  const Models& models;

  // Returns the number of repetitions that the figures need, or a few for a quick run.
  [[nodiscard]] int runs(int thorough) const { return quick ? std::min(thorough, 3) : thorough; }
};

inline constexpr const char* kPlate = "plate-figurines-935k.stl";
inline constexpr const char* kLiver = "minetto-liver.stl";
inline constexpr const char* kFemur = "minetto-femur.stl";
inline constexpr const char* kBunny = "bunny-stanford-x4-278k.stl";
// A layer that results in the layer counts of the thesis and of Minetto et al.
inline constexpr Nanometers kThinLayer{32'000};
inline constexpr std::uint64_t kSeed = 2019;  // seed of the random heights

// Returns an engine with the model fitted to the display, as in the thesis.
[[nodiscard]] ContourEngine fitted_engine(const std::filesystem::path& model, Pixels width, Pixels height);

// Returns nearly uniform heights within a model, the same in every run.
[[nodiscard]] std::vector<Millimeters> random_heights(const Bounds& bounds, int count);

// Returns a skipped row for every id, for a model that is not available.
[[nodiscard]] std::vector<Row> skipped_rows(const std::vector<std::string>& ids, const std::string& model);

// contour_rows.cpp: linked contours of all layers.
[[nodiscard]] std::vector<Row> contour_rows(const Bench& bench);
// print_rows.cpp: all masks of a model, in memory and as files.
[[nodiscard]] std::vector<Row> print_rows(const Bench& bench);
// mask_rows.cpp: one mask, at random and rising heights.
[[nodiscard]] std::vector<Row> mask_rows(const Bench& bench);
// dimming_rows.cpp: masks with dimmed undersides, beside plain ones.
[[nodiscard]] std::vector<Row> dimming_rows(const Bench& bench);
// cure_rows.cpp: the part that a print's light makes, beside the print's masks alone.
[[nodiscard]] std::vector<Row> cure_rows(const Bench& bench);
// support_rows.cpp: the time that supports, and cavities, add to a mask.
[[nodiscard]] std::vector<Row> support_rows(const Bench& bench);
// load_rows.cpp: from a file to the first mask; reading; memory.
[[nodiscard]] std::vector<Row> load_rows(const Bench& bench);
// Runs in a child process: prints its peak memory after a model's first mask.
void print_memory_of_first_mask(const std::filesystem::path& model);
// display_rows.cpp: converting a mask to a picture for the screen, as it is written to a graphics card's
// memory.
[[nodiscard]] std::vector<Row> display_rows(const Bench& bench);
// allocation_rows.cpp: calls of operator new.
[[nodiscard]] std::vector<Row> allocation_rows(const Bench& bench);
// growth_rows.cpp: time against facets, and against segments.
[[nodiscard]] std::vector<Row> growth_rows(const Bench& bench);
// instruction_rows.cpp: instructions, counted by callgrind in a child of this program.
[[nodiscard]] std::vector<Row> instruction_rows(const Bench& bench);
// Runs in a child process: prints how many times `thing` was done, and on how many segments, facets or bytes.
void do_measured(const std::string& thing, const std::filesystem::path& model);

}  // namespace contourd::bench
