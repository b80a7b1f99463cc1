// Drops a file onto a window as a file manager does, by the XDND protocol, version 5.
// Usage: drop_file WINDOW FILE; exit 0 once the window says that it has taken the file.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

#include <X11/Xatom.h>
#include <X11/Xlib.h>

namespace {

class Source {
 public:
  Source(Display* display, Window target, std::string uri)
      : display_(display),
        window_(XCreateSimpleWindow(display, XDefaultRootWindow(display), 0, 0, 1, 1, 0, 0, 0)),
        target_(target),
        uri_(std::move(uri)) {}

  bool drop() {
    XSetSelectionOwner(display_, atom("XdndSelection"), window_, CurrentTime);
    send("XdndEnter", {long{5} << 24, static_cast<long>(atom("text/uri-list")), 0, 0});
    send("XdndPosition", {0, 0, CurrentTime, static_cast<long>(atom("XdndActionCopy"))});
    send("XdndDrop", {0, CurrentTime, 0, 0});
    for (int tenths = 0; tenths < 100; ++tenths) {
      for (XFlush(display_); XPending(display_) > 0;) {
        XEvent event;
        XNextEvent(display_, &event);
        if (event.type == SelectionRequest) {
          give(event.xselectionrequest);
        } else if (event.type == ClientMessage &&
                   event.xclient.message_type == atom("XdndFinished")) {
          return true;
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }

 private:
  Atom atom(const char* name) { return XInternAtom(display_, name, False); }

  void send(const char* type, std::array<long, 4> data) {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = target_;
    event.xclient.message_type = atom(type);
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(window_);
    std::copy(data.begin(), data.end(), event.xclient.data.l + 1);
    XSendEvent(display_, target_, False, NoEventMask, &event);
  }

  void give(const XSelectionRequestEvent& request) {
    XChangeProperty(display_, request.requestor, request.property, request.target, 8,
                    PropModeReplace, reinterpret_cast<const unsigned char*>(uri_.data()),
                    static_cast<int>(uri_.size()));
    XEvent event{};
    event.xselection.type = SelectionNotify;
    event.xselection.requestor = request.requestor;
    event.xselection.selection = request.selection;
    event.xselection.target = request.target;
    event.xselection.property = request.property;
    event.xselection.time = request.time;
    XSendEvent(display_, request.requestor, False, NoEventMask, &event);
  }

  Display* display_;
  Window window_, target_;
  std::string uri_;
};

}  // namespace

int main(int argc, char** argv) {
  Display* const display = argc == 3 ? XOpenDisplay(nullptr) : nullptr;
  if (display == nullptr) {
    std::fprintf(stderr, "usage: drop_file WINDOW FILE, with a display\n");
    return 2;
  }
  const std::string uri = "file://" + std::filesystem::absolute(argv[2]).string() + "\r\n";
  return Source(display, std::strtoul(argv[1], nullptr, 0), uri).drop() ? 0 : 1;
}
