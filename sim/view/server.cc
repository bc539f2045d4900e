#include "sim/view/server.h"

#include <fmt/format.h>
#include <libdeflate.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cctype>
#include <future>
#include <list>
#include <numeric>
#include <random>
#include <regex>
#include <stdexcept>
#include <thread>

#include "sim/files/hash.h"
#include "sim/files/text.h"

namespace sim::view {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using net::ip::tcp;

using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;
using Error = beast::error_code;
using Slot = std::shared_ptr<void>;  ///< counts a connection while it exists

constexpr std::size_t kLeastTokenLength = 22;  // 128 bits, also in base64

std::string_view plain(beast::string_view text) { return {text.data(), text.size()}; }

/// An address in the browser: scheme://shown/path. `shown` omits the scheme's default port, as browsers do.
struct Place {
  std::string scheme, shown, full, path;
  std::string origin() const { return scheme + "://" + shown; }
};

std::optional<Place> place_of(const std::string& text) {
  static const std::regex form(
      R"((?:(https?)://)?([A-Za-z0-9.-]+|\[[0-9A-Fa-f:]+\])(?::([0-9]{1,5}))?((?:/[A-Za-z0-9._~-]+)*)/?)");
  std::smatch part;
  if (!std::regex_match(text, part, form) || !(part[1].matched || part[3].matched)) return std::nullopt;
  const auto port = files::parse_number<std::uint16_t>(part[3].str());
  if (part[3].matched && port.value_or(0) == 0) return std::nullopt;
  const std::string scheme = part[1].matched ? part[1].str() : port == 443 ? "https" : "http", host = part[2];
  const std::uint16_t usual = scheme == "https" ? 443 : 80, used = port.value_or(usual);
  const std::string full = fmt::format("{}:{}", host, used);
  return Place{scheme, used == usual ? host : full, full, part[4]};
}

/// Returns all addresses that lead to this server.
std::vector<Place> places(const Access& access) {
  const std::string own = authority(access);
  std::vector<Place> all{place_of(own).value_or(Place{"http", own, own, ""})};
  for (const std::string& forwarded : access.forwarded) all.push_back(place_of(forwarded).value());
  return all;
}

/// Returns the policy of every response: only the server's own scripts and styles, and no framing.
std::string content_security_policy(const Access& access) {
  std::string sockets;
  for (const Place& place : places(access))
    sockets += fmt::format(" {}://{}", place.scheme == "https" ? "wss" : "ws", place.shown);
  return fmt::format(
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'{}; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
      sockets);
}

/// Compresses fast, because the browser is on a fast connection. Compressed pictures stay as they are.
std::optional<std::string> compressed(std::string_view bytes) {
  constexpr std::size_t kSmall = 1024;
  if (bytes.size() < kSmall || bytes.starts_with("\x89PNG")) return std::nullopt;
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(1), &libdeflate_free_compressor);
  std::string out(libdeflate_gzip_compress_bound(compressor.get(), bytes.size()), '\0');
  out.resize(libdeflate_gzip_compress(compressor.get(), bytes.data(), bytes.size(), out.data(), out.size()));
  return out;
}

/// State shared by all connections, used by the server's thread.
struct Shared {
  Access access;
  Service service;
  Limits limits;
  std::size_t connections = 0;
  std::list<std::weak_ptr<class SocketClient>> sockets;
  std::atomic<bool> has_room{false};  // a client has room in its queue

  void count_rooms();
  std::size_t viewers() const;
};

class SocketClient : public Client, public std::enable_shared_from_this<SocketClient> {
 public:
  SocketClient(std::shared_ptr<Shared> shared, Slot slot, beast::tcp_stream stream)
      : shared_(std::move(shared)),
        slot_(std::move(slot)),
        socket_(std::move(stream)),
        queue_(shared_->limits.queued_frames, shared_->limits.queued_messages) {}

  void accept(const Request& request) {
    beast::get_lowest_layer(socket_).expires_never();
    socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    socket_.set_option(websocket::stream_base::decorator([this](websocket::response_type& response) {
      response.set(http::field::sec_websocket_protocol, shared_->service.protocol);
    }));
    socket_.auto_fragment(false);  // each fragment would cost a system call
    socket_.read_message_max(shared_->limits.message_bytes);
    socket_.async_accept(request, [self = shared_from_this()](Error error) {
      if (!error) self->opened();
    });
  }

  void send(Message message) override {
    if (closing_) return;
    if (!queue_.push(std::move(message))) return give_up();
    write();
    shared_->count_rooms();
  }

  bool is_closing() const { return closing_; }
  bool has_room() const override { return open_ && !closing_ && queue_.has_room(); }
  std::size_t waiting() const { return open_ && !closing_ ? queue_.size() + (writing_ ? 1 : 0) : 0; }

 private:
  void opened() {
    open_ = true;
    shared_->sockets.push_back(weak_from_this());
    guarded([this] { shared_->service.opened(*this); });
    shared_->count_rooms();
    read();
  }

  void read() {
    socket_.async_read(read_,
                       [self = shared_from_this()](Error error, std::size_t) { self->on_read(error); });
  }

  void on_read(Error error) {
    if (error) return give_up();
    if (socket_.got_text()) {
      const std::string text = beast::buffers_to_string(read_.data());
      guarded([&] { shared_->service.received(*this, text); });
    }
    read_.consume(read_.size());
    if (!closing_) read();
  }

  void write() {
    if (writing_ || closing_ || !open_) return;
    const std::optional<Message> next = queue_.pop();
    if (!next) return;
    writing_ = true;
    socket_.text(!next->is_frame);
    socket_.async_write(net::buffer(*next->bytes),
                        [self = shared_from_this(), bytes = next->bytes](Error error, std::size_t) {
                          self->writing_ = false;
                          if (error) return self->give_up();
                          self->write();
                          self->shared_->count_rooms();
                        });
  }

  // Pending operations then end with errors, and the last one releases this object.
  void give_up() {
    if (std::exchange(closing_, true)) return;
    beast::get_lowest_layer(socket_).close();
    shared_->count_rooms();
    if (open_) shared_->service.closed(shared_->viewers());
  }

  template <class Action>
  void guarded(const Action& action) try {
    action();
  } catch (const std::exception&) {
    give_up();
  }

  std::shared_ptr<Shared> shared_;
  Slot slot_;
  websocket::stream<beast::tcp_stream> socket_;
  MessageQueue queue_;
  beast::flat_buffer read_;
  bool open_ = false, writing_ = false, closing_ = false;
};

void Shared::count_rooms() {
  sockets.remove_if([](const auto& socket) { return socket.expired(); });
  has_room = std::ranges::any_of(sockets, [](const auto& socket) {
    const auto client = socket.lock();
    return client && client->has_room();
  });
}

std::size_t Shared::viewers() const {
  return static_cast<std::size_t>(std::ranges::count_if(sockets, [](const auto& socket) {
    const auto client = socket.lock();
    return client && !client->is_closing();
  }));
}

/// A connection that handles HTTP requests, one after another, until it becomes a WebSocket.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(std::shared_ptr<Shared> shared, tcp::socket socket)
      : shared_(std::move(shared)),
        slot_(nullptr, [shared = shared_](void*) { --shared->connections; }),
        stream_(std::move(socket)) {
    ++shared_->connections;
  }

  void read() {
    parser_.emplace();
    parser_->header_limit(shared_->limits.header_bytes);
    parser_->body_limit(0);
    stream_.expires_after(shared_->limits.request);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](Error error, std::size_t) { self->on_read(error); });
  }

 private:
  void on_read(Error error) {
    if (error == http::error::header_limit) return answer(431, "the request's header is too long", false);
    if (error == http::error::unexpected_body || error == http::error::body_limit)
      return answer(413, "the request has a body, expected none", false);
    if (error) return;
    const Request request = parser_->release();
    RequestHead head{plain(request.method_string()), plain(request.target()),
                     plain(request[http::field::host])};
    if (request.count(http::field::host) != 1) head.host = {};
    if (request.count(http::field::origin) != 0) head.origin = plain(request[http::field::origin]);
    if (const auto rejected = rejection(head, shared_->access))
      return answer(rejected->status, rejected->why, false);
    if (websocket::is_upgrade(request)) return upgrade(request);
    const http::token_list encodings(request[http::field::accept_encoding]);
    takes_gzip_ = std::ranges::any_of(encodings, [](const auto& name) { return name == "gzip"; });
    known_ = plain(request[http::field::if_none_match]);
    serve(served_path(head.target, shared_->access), request.keep_alive());
  }

  void serve(std::string_view path, bool keep) try {
    const auto resource = shared_->service.resource(path);
    if (!resource) return answer(404, "no such file", keep);
    files::Hash hash;
    hash.add(*resource->bytes);
    const std::string etag = fmt::format("\"{}\"", hash.hex());
    const bool is_known = etag == known_;
    respond(is_known ? 304 : 200, resource->type, is_known ? "" : *resource->bytes, keep, etag);
  } catch (const std::exception& failure) {
    answer(500, failure.what(), false);
  }

  void upgrade(const Request& request) {
    if (plain(request[http::field::sec_websocket_protocol]) != shared_->service.protocol)
      return answer(400, "unknown subprotocol", false);
    std::make_shared<SocketClient>(shared_, slot_, std::move(stream_))->accept(request);
  }

  void answer(unsigned status, std::string_view why, bool keep) {
    respond(status, "text/plain; charset=utf-8", std::string(why) + "\n", keep);
  }

  /// etag: for content that a browser may cache and revalidate.
  void respond(unsigned status, const std::string& type, std::string body, bool keep,
               const std::string& etag = "") {
    std::optional<std::string> smaller = takes_gzip_ ? compressed(body) : std::nullopt;
    const bool is_smaller = smaller && smaller->size() < body.size();
    if (is_smaller) body = std::move(*smaller);
    const auto response = std::make_shared<Response>(http::status(status), 11, std::move(body));
    response->set(http::field::content_type, type);
    if (is_smaller) response->set(http::field::content_encoding, "gzip");
    response->set(http::field::cache_control, etag.empty() ? "no-store" : "private, no-cache");
    if (!etag.empty()) response->set(http::field::etag, etag);
    response->set("Content-Security-Policy", content_security_policy(shared_->access));
    response->set("X-Content-Type-Options", "nosniff");
    response->set("X-Frame-Options", "DENY");
    response->set("Referrer-Policy", "no-referrer");
    response->set("Cross-Origin-Resource-Policy", "same-origin");
    response->set("Cross-Origin-Opener-Policy", "same-origin");
    response->keep_alive(keep);
    response->prepare_payload();
    stream_.expires_after(shared_->limits.response);
    http::async_write(stream_, *response, [self = shared_from_this(), response](Error error, std::size_t) {
      if (!error && !response->need_eof()) return self->read();
      Error ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  std::shared_ptr<Shared> shared_;
  Slot slot_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  bool takes_gzip_ = false;
  std::string known_;  // hash of the version that the browser already has
  std::optional<http::request_parser<http::empty_body>> parser_;
};

}  // namespace

std::string new_token() {
  std::random_device source("/dev/urandom");
  std::string token;
  for (int word = 0; word < 4; ++word) token += fmt::format("{:08x}", source());
  return token;
}

Access checked(Access access) {
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(access.address, error);
  const char* const complaint = error ? "is not an IP address, expected one of this machine"
                                : address.is_unspecified() ? "means all interfaces, expected a single one"
                                : !address.is_loopback() && access.token.empty()
                                    ? "can be reached by others, expected a --token of your own"
                                    : nullptr;
  if (complaint) throw std::invalid_argument(fmt::format("--address {}: {}", access.address, complaint));
  if (access.token.empty()) access.token = new_token();
  const bool plain = std::ranges::all_of(
      access.token, [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_'; });
  if (access.token.size() < kLeastTokenLength || !plain)
    throw std::invalid_argument("--token: expected at least 22 letters, digits, - or _");
  for (const std::string& place : access.forwarded)
    if (!place_of(place))
      throw std::invalid_argument(fmt::format(
          "--public {}: expected HOST:PORT or http[s]://HOST[:PORT][/PATH] as in the browser, such as "
          "localhost:8020",
          place));
  return access;
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  return a.size() == b.size() &&
         std::inner_product(a.begin(), a.end(), b.begin(), 0, std::bit_or<>(), std::bit_xor<>()) == 0;
}

std::string authority(const Access& access) {
  const bool v6 = access.address.find(':') != std::string::npos;
  return fmt::format(fmt::runtime(v6 ? "[{}]:{}" : "{}:{}"), access.address, access.port);
}

std::string url(const Access& access) {
  const std::vector<Place> all = places(access);
  const Place& place = all.at(access.forwarded.empty() ? 0 : 1);
  return fmt::format("{}{}/?token={}", place.origin(), place.path, access.token);
}

std::string_view served_path(std::string_view target, const Access& access) {
  const std::string_view path = target.substr(0, target.find('?'));
  for (const Place& place : places(access))
    if (!place.path.empty() && path.starts_with(place.path + "/")) return path.substr(place.path.size());
  return path;
}

std::optional<Rejection> rejection(const RequestHead& request, const Access& access) {
  const std::vector<Place> all = places(access);
  const std::string host(request.host.substr(0, 256));
  if (std::ranges::none_of(all, [&](const Place& p) { return host == p.shown || host == p.full; })) {
    const bool has_port = place_of(host).has_value(), is_host = place_of("https://" + host).has_value();
    return Rejection{
        421, fmt::format("the address in the browser is not this server's ({}); if you forward it, as with "
                         "ssh -L or a proxy, allow it by starting the view with --public {}",
                         authority(access),
                         has_port  ? host
                         : is_host ? fmt::format("https://{} or http://{}", host, host)
                                   : "HOST:PORT")};
  }
  if (request.origin && std::ranges::find(all, *request.origin, &Place::origin) == all.end())
    return Rejection{403, "the Origin is not this server"};
  constexpr std::string_view kName = "?token=";  // the first of the query
  const std::size_t query = request.target.find(kName);
  std::string_view token = query == request.target.npos ? "" : request.target.substr(query + kName.size());
  token = token.substr(0, token.find('&'));
  if (!equal_in_constant_time(token, access.token)) return Rejection{403, "missing or wrong token"};
  if (request.method != "GET") return Rejection{405, "unsupported method, expected GET"};
  return std::nullopt;
}

struct Server::Implementation {
  Implementation(const Access& access, Service service, const Limits& limits)
      : shared(std::make_shared<Shared>()), acceptor(context) {
    shared->access = checked(access);
    shared->service = std::move(service);
    shared->limits = limits;
    listen();
  }

  void listen() try {
    const tcp::endpoint endpoint(net::ip::make_address(shared->access.address), shared->access.port);
    acceptor.open(endpoint.protocol());
    acceptor.set_option(net::socket_base::reuse_address(true));
    acceptor.bind(endpoint);
    acceptor.listen();
    shared->access.port = acceptor.local_endpoint().port();
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error(fmt::format("cannot listen on {}: {}; --port 0 selects any free port",
                                         authority(shared->access), error.code().message()));
  }

  void accept() {
    acceptor.async_accept([this](Error error, tcp::socket socket) {
      if (error == net::error::operation_aborted) return;
      if (!error && shared->connections < shared->limits.clients) {
        socket.set_option(tcp::no_delay(true), error);
        std::make_shared<HttpConnection>(shared, std::move(socket))->read();
      }
      accept();
    });
  }

  std::pair<std::size_t, std::size_t> unfinished() const {
    std::size_t messages = 0, pages = 0;
    for (const auto& socket : shared->sockets)
      if (const auto client = socket.lock(); client && !client->is_closing())
        messages += client->waiting(), pages += client->loading ? 1 : 0;
    return {messages, pages};
  }

  net::io_context context{1};
  std::shared_ptr<Shared> shared;
  tcp::acceptor acceptor;
  std::thread thread;
};

Server::Server(const Access& access, Service service, const Limits& limits)
    : implementation_(std::make_unique<Implementation>(access, std::move(service), limits)) {
  implementation_->accept();
  implementation_->thread = std::thread([self = implementation_.get()] { self->context.run(); });
}

Server::~Server() {
  implementation_->context.stop();
  implementation_->thread.join();
}

const Access& Server::access() const { return implementation_->shared->access; }

void Server::for_each(std::function<void(Client&)> action) {
  net::post(implementation_->context, [self = implementation_.get(), action = std::move(action)] {
    const auto sockets = self->shared->sockets;  // a copy, because an action may end one of them
    for (const auto& socket : sockets)
      if (const auto client = socket.lock()) action(*client);
  });
}

bool Server::has_room() const { return implementation_->shared->has_room; }

void Server::flush(std::chrono::milliseconds queues, std::chrono::milliseconds loading) {
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = begin;
  for (;;) {
    std::promise<std::pair<std::size_t, std::size_t>> answer;
    net::post(implementation_->context, [&] { answer.set_value(implementation_->unfinished()); });
    const auto [messages, pages] = answer.get_future().get();
    const auto now = std::chrono::steady_clock::now();
    if (pages > 0 && now - begin <= loading)
      loaded = now;
    else if (messages == 0 || now - loaded > queues)
      return;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

}  // namespace sim::view
