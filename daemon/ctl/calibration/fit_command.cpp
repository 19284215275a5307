#include <optional>
#include <string>

#include "daemon/ctl/calibration/calibration_commands.hpp"
#include "daemon/ctl/calibration/fit_result.hpp"

namespace contourd::ctl {
namespace {

void add_undo(Command& fit) {
  struct UndoArgs {
    std::filesystem::path printer;
    std::optional<std::string> resin;
  };
  Command& command = fit.add("undo", "Take back the last accepted result");
  auto& args = command.arguments<UndoArgs>();
  args.printer = kDefaultConfig;
  command.option("RESIN", args.resin, "Resin profile; without it, the printer's configuration");
  command.option("--printer", args.printer, "Configuration of the printer");
  command.run = [&args] {
    return undo_fit(args.resin
                        ? resin_target(load_printer_config(args.printer, Places::Elsewhere), *args.resin)
                        : printer_target(args.printer));
  };
}

}  // namespace

void add_fit(Command& program) {
  Command& fit = program.add("fit", "Compute figures from what was measured on a calibration print");
  add_fit_lamp(fit);
  add_fit_windows(fit);
  add_fit_exposure(fit);
  add_fit_models(fit);
  add_undo(fit);
}

}  // namespace contourd::ctl
