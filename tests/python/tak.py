"""Where TAK would be: receives events of Cursor on Target by pytak, and reads them by takproto.

Arguments: udp PORT; tcp; or tls CERTIFICATE KEY CA [VERSION], files in PEM and the newest version of TLS, such as 1.2. Servers
take any free port and print it. Each event becomes a line of JSON. The line `drop` on standard input closes all connections;
the program ends with standard input.
"""

import asyncio
import json
import ssl
import sys
import xml.etree.ElementTree as ElementTree
from urllib.parse import urlparse

import pytak
import takproto
from takproto.functions import msg2proto

connections = []


class Reader(pytak.RXWorker):
    """Prints each event that a connection brings."""

    def __init__(self, reader, number):
        super().__init__(asyncio.Queue(), {"TAK_PROTO": "1"}, reader)
        self.number = number

    async def handle_data(self, data):
        """Nothing is queued."""

    async def read_all(self):
        while (message := await self.readcot()) is not None:
            print(json.dumps({"connection": self.number, **fields(message)}), flush=True)


def fields(message):
    """What takproto has read, after a round trip through TAK's own binary form."""
    sent = msg2proto(message, takproto.TAKProtoVer.MESH)
    event = takproto.parse_proto(sent).cotEvent
    detail = ElementTree.fromstring(f"<detail>{event.detail.xmlDetail}</detail>")
    links = detail.findall("link")
    removes = [link.get("uid") for link in links if link.get("uid") is not None]
    assert (detail.find("__forcedelete") is not None) == (event.type == "t-x-d-d"), event
    return {
        "uid": event.uid,
        "type": event.type,
        "how": event.how,
        "time_ms": event.sendTime,
        "start_ms": event.startTime,
        "stale_ms": event.staleTime,
        "point": [event.lat, event.lon, event.ce],
        "callsign": event.detail.contact.callsign,
        "remarks": detail.findtext("remarks"),
        "track": [event.detail.track.course, event.detail.track.speed],
        "corners": [[float(it) for it in link.get("point").split(",")] for link in links if link.get("point")],
        "removes": removes[0] if removes else None,
    }


async def accept(reader, writer):
    connections.append(writer)
    number = len(connections)
    # As a server passes on what others send.
    writer.write(b"<event/>" * 1000)
    try:
        await Reader(reader, number).read_all()
    except OSError:
        pass


async def serve(arguments):
    match arguments:
        case ["udp", port]:
            reader, _ = await pytak.create_udp_client(urlparse(f"udp+ro://127.0.0.1:{port}"))
            print(port, flush=True)
            return asyncio.ensure_future(Reader(reader, 0).read_all())
        case ["tcp"]:
            context = None
        case ["tls", certificate, key, ca, *version]:
            context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH, cafile=ca)
            context.load_cert_chain(certificate, key)
            context.verify_mode = ssl.CERT_REQUIRED
            if version:
                context.maximum_version = {"1.2": ssl.TLSVersion.TLSv1_2}[version[0]]
    server = await asyncio.start_server(accept, "127.0.0.1", 0, ssl=context)
    print(server.sockets[0].getsockname()[1], flush=True)
    return server


async def main():
    server = await serve(sys.argv[1:])
    while command := await asyncio.to_thread(sys.stdin.readline):
        if command.strip() == "drop":
            for writer in connections:
                writer.transport.abort()
    del server


asyncio.run(main())
