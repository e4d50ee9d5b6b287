// Runs a cart and its controller as two programs in lock-step by UDP. Together they are one simulation.
//
//     lock_step controller      in one terminal, first: it waits for the plant
//     lock_step plant           in another terminal
//     lock_step                 runs both, and compares them with the loop in one program

#include "../cart/cart.h"
#include "remote.h"
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

namespace {

constexpr double kEnd = 1;  // s

// The loop in one program. Plant and controller can each be replaced by a block that connects to the other
// program.
struct Loop {
  tenon::DiagramBuilder builder;
  Cart& cart = builder.Add<Cart>("cart");
  Pd& pd = builder.Add<Pd>("pd");
  Loop() {
    auto& ref = builder.AddFunction({"ref", "m"}, tenon::Uses(builder.time),
                                    [](double t) { return t < 0.1 ? 0.0 : 0.2; });
    builder.Connect(cart.state, pd.x);
    builder.Connect(ref, pd.ref);
    builder.Connect(pd.u, cart.force);
  }
};

// Returns state and force at every tick.
std::vector<double> RunAndLog(tenon::DiagramBuilder& builder, const tenon::Source& state,
                              const tenon::Source& force) {
  tenon::Simulator simulator(builder.Build());
  const auto log = simulator.AddLog(tenon::Hz(1000), {&state, &force});
  simulator.RunTo(kEnd);
  std::vector<double> rows;
  for (std::size_t i = 0; i < log->rows(); ++i)
    rows.insert(rows.end(), log->row(i).begin(), log->row(i).end());
  return rows;
}

std::vector<double> RunPlant(const Link& link) {
  Loop loop;
  const auto& remote = loop.builder.Replace<RemotePd>(loop.pd, link);
  return RunAndLog(loop.builder, loop.cart.state, remote.u);
}

std::vector<double> RunController(const Link& link) {
  Loop loop;
  const auto& remote = loop.builder.Replace<RemoteCart>(loop.cart, link);
  return RunAndLog(loop.builder, remote.state, loop.pd.u);
}

int Compare() {
  // Loopback addresses made from the process id, so that several such programs can run at once.
  const auto process = static_cast<unsigned>(getpid());
  Link link;
  link.plant = link.controller = "127." + std::to_string(process >> 16 & 127) + "." +
                                 std::to_string(process >> 8 & 255) + "." + std::to_string(process & 255);
  // The controller opens its port before the plant sends.
  Loop half;
  const auto& remote_cart = half.builder.Replace<RemoteCart>(half.cart, link);
  const pid_t child = fork();
  if (child == 0) {
    int code = 1;
    try {
      RunAndLog(half.builder, remote_cart.state, half.pd.u);
      code = 0;
    } catch (const std::exception& error) {
      std::fprintf(stderr, "controller: %s\n", error.what());
    }
    _exit(code);
  }
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const std::vector<double> apart = RunPlant(link);
  const std::chrono::duration<double, std::micro> elapsed = Clock::now() - begin;
  int status = 1;
  waitpid(child, &status, 0);

  Loop whole;
  const bool same = RunAndLog(whole.builder, whole.cart.state, whole.pd.u) == apart;
  std::printf("%zu ticks of %.0f us: %s\n", apart.size() / 4, elapsed.count() / (apart.size() / 4.0),
              same ? "bit for bit as in one program" : "NOT as in one program");
  return same && status == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string half = argc > 1 ? argv[1] : "";
  if (half.empty()) return Compare();
  const std::vector<double> rows = half == "plant" ? RunPlant({}) : RunController({});
  std::printf("%s: at t = %g s the cart is at %.17g m\n", half.c_str(), kEnd, rows[rows.size() - 3]);
} catch (const std::exception& error) {
  std::fprintf(stderr, "lock_step: %s\n", error.what());
  return 1;
}
