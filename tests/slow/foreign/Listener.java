// Decodes every channel named on its command line by the classes of a jar; prints counts and sums when its input ends.

import java.io.DataInput;
import java.util.Map;
import java.util.TreeMap;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMSubscriber;

public class Listener implements LCMSubscriber {
    private final Map<String, Class<?>> types = new TreeMap<>();
    private final Map<String, long[]> sums = new TreeMap<>();

    // words: URL CHANNEL=TYPE ...
    public static void main(String[] words) throws Exception {
        Listener listener = new Listener();
        for (int i = 1; i < words.length; i++) {
            String[] pair = words[i].split("=");
            Class<?> type = Class.forName(pair[1]);
            type.getConstructor().newInstance();
            listener.types.put(pair[0], type);
            listener.sums.put(pair[0], new long[3]);
        }
        LCM lcm = new LCM(words[0]);
        lcm.subscribeAll(listener);
        System.out.println("ready");
        while (System.in.read() >= 0) { }
        Thread.sleep(500);  // what was sent last is on its way
        listener.sums.forEach((name, sum) -> System.out.println(name + " " + sum[0] + " " + sum[1] + " " + sum[2]));
        System.exit(0);
    }

    public synchronized void messageReceived(LCM lcm, String channel, LCMDataInputStream in) {
        Class<?> type = types.get(channel);
        if (type == null)
            return;
        try {
            Object message = type.getConstructor(DataInput.class).newInstance(in);
            long[] sum = sums.get(channel);
            sum[0]++;
            sum[1] += type.getField("utime").getLong(message);
            sum[2] += type.getField("seq").getLong(message);
        } catch (ReflectiveOperationException error) {
            System.err.println(channel + ": " + error);
        }
    }
}
