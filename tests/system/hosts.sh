# Hosts of their own on one machine, each a network namespace: two switches, `left` and `right`, joined by a trunk; and
# one more, on which the simulated world shows robots what they see. All of it is gone when this ends.
#
# Does what standard input says, line by line, and answers `done`:
#   host NAME NUMBER SWITCH     a host at 10.0.0.NUMBER, and at 10.9.0.NUMBER for the world
#   start NAME HOST COMMAND...  a process there; what it says goes to NAME.out and NAME.log
#   kill NAME SIGNAL
#   wait NAME                   answers once the process has ended
#   link INTERFACE up|down      `trunk`, or that of a host
#   lose HOST PERCENT           of all packets of the team that arrive there, drawn one by one
set -eu
cd "$1"
mount -t tmpfs tmpfs /run
ip link set lo up
for switch in left right world; do
    ip link add name "$switch" type bridge
    ip link set "$switch" up
done
ip link add name trunk type veth peer name trunk2
ip link set trunk master left
ip link set trunk2 master right
ip link set trunk up
ip link set trunk2 up

# NAME INTERFACE SWITCH ADDRESS
plug() {
    ip link add name "$2" type veth peer name "$2" netns "$1"
    ip link set "$2" master "$3" up
    ip -n "$1" address add "$4/24" dev "$2"
    ip -n "$1" link set "$2" up
}

declare -A processes
while read -r order name rest; do
    set -- $rest
    case $order in
        host)
            ip netns add "$name"
            ip -n "$name" link set lo up
            plug "$name" "air$1" "$2" "10.0.0.$1"
            plug "$name" "world$1" world "10.9.0.$1"
            ;;
        start)
            host=$1
            shift
            ip netns exec "$host" "$@" >> "$name.out" 2>> "$name.log" < /dev/null &
            processes[$name]=$!
            ;;
        kill) kill "-$1" "${processes[$name]}" ;;
        wait) wait "${processes[$name]}" || true ;;
        link) ip link set "$name" "$1" ;;
        lose)
            ip netns exec "$name" nft -f - <<< "table ip air {
                chain arriving {
                    type filter hook input priority filter
                    ip saddr 10.0.0.0/24 numgen random mod 100 < $1 counter drop
                }
            }"
            ;;
    esac
    echo done
done
