// Jobs of one model and of a plate, prepared for the shipped simulated printer, a plate of 96 x 54 mm with
// pixels of 50 um. Not thread-safe.
#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "daemon/prepare/print_job.hpp"
#include "tests/daemon/config/config_fixture.hpp"
#include "tests/daemon/print/rise_fixture.hpp"
#include "tests/message_of.hpp"
#include "tests/models/models.hpp"

namespace contourd::testing {

// Calls `prepare` and returns why it refuses the job; empty if it does not.
template <typename Prepare>
std::string refusal_by(Prepare prepare) {
  return testing::message_of<JobRefused>([&] { prepare(); });
}

// A job of one model.
class PrintJobFixture {
 public:
  PrintJobFixture()
      : printer(load_printer_config(std::filesystem::path(CONTOURD_CONFIG_DIR) / "simulated.json")),
        resin(find_resin(printer, printer.resin)) {
    printer.supports = SupportPolicy::Off;
  }

  // Prepares the job; nullopt if `stop` was requested.
  std::optional<PreparedJob> prepare_until(const models::Facets& facets, const std::string& ticket,
                                           const std::stop_token& stop) {
    JobFiles files{"part", folder_.path() / "part.stl", std::nullopt};
    models::write_binary_stl(files.model, facets);
    if (!ticket.empty()) files.ticket = folder_.write("part.json", ticket);
    JobSettings settings = read_settings(files, printer);
    if (!settings.ticket.resin) settings.resin = resin;
    return prepare_job(files, settings, printer, stop);
  }
  PreparedJob prepare(const models::Facets& facets, const std::string& ticket = "") {
    return *prepare_until(facets, ticket, {});
  }
  std::string refusal_of(const models::Facets& facets, const std::string& ticket = "") {
    return refusal_by([&] { (void)prepare(facets, ticket); });
  }

  // Gives the resin a window and the way of its prints.
  void make_continuous() {
    const ResinProfile window = window_resin();
    resin.cure = window.cure;
    resin.continuous = window.continuous;
    resin.mode = PrintWay::Continuous;
    printer.irradiance_mw_cm2 = 4;
  }

  PrinterConfig printer;
  ResinProfile resin;  // used by jobs that do not name a resin

 private:
  TemporaryFolder folder_;
};

inline const models::Facets kCube = models::box({0, 0, 0}, {20, 20, 20});

// The first and last column and row with a lit pixel.
struct Lit {
  int left, right, top, bottom;
  bool operator==(const Lit&) const = default;
};

inline Lit lit_box(const Mask& mask) {
  Lit lit{mask.width().count(), -1, mask.height().count(), -1};
  for (int y = 0; y < mask.height().count(); ++y) {
    const auto row = mask.row(y);
    for (int x = 0; x < mask.width().count(); ++x) {
      if (row[static_cast<std::size_t>(x)] == 0) continue;
      lit = {std::min(lit.left, x), std::max(lit.right, x), std::min(lit.top, y), std::max(lit.bottom, y)};
    }
  }
  return lit;
}

// A job of a plate: its folder with models.
class PlateFixture : public PrintJobFixture {
 public:
  PlateFixture() { std::filesystem::create_directory(plate_); }

  void add(const std::string& file, const models::Facets& facets) {
    models::write_binary_stl(plate_ / file, facets);
  }
  PreparedJob prepare(const std::string& ticket) {
    folder_.write("plate/plate.json", ticket);
    const JobFiles files{"plate", plate_, std::nullopt, true};
    return prepare_job(files, read_settings(files, printer), printer);
  }
  std::string refusal_of(const std::string& ticket) {
    return refusal_by([&] { (void)prepare(ticket); });
  }

 private:
  TemporaryFolder folder_;
  std::filesystem::path plate_ = folder_.path() / "plate";
};

}  // namespace contourd::testing
